/* Compile-time proof that registers.h lies where the manuals say. Included by registers.h only: a wrong offset stops
 * every build that touches a register. Word offsets from SPRUFB0, SPRUG04, SPRU812, SPRUG05. */
CHECK_OFFSET(cpu_timer_regs_t, PRD, 2u);
CHECK_OFFSET(cpu_timer_regs_t, TCR, 4u);
CHECK_OFFSET(cpu_timer_regs_t, TPR, 6u);
CHECK_OFFSET(cpu_timer_regs_t, TPRH, 7u);
