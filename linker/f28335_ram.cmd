/* F28335, image in RAM, loaded by a debugger or by the boot ROM's loaders, which start it at 0x000000. All numbers
 * count 16-bit words. Where the code runs is where it is loaded: hal_boot copies it onto itself. What the interrupt
 * does not run may spill into L4-L7, whose program fetches take one wait. Behind 0xFFFF is no memory, and the CPU
 * fetches up to 8 words beyond the instruction it is at: L4-L7 ends 8 words short. */
MEMORY
{
    ENTRY      : origin = 0x000000, length = 0x000002
    M0_M1      : origin = 0x000050, length = 0x0007B0 /* below: the boot ROM's stack and data */
    L0_L3      : origin = 0x008000, length = 0x004000
    L4_L7      : origin = 0x00C000, length = 0x003FF8
    FPU_TABLES : origin = 0x3FEBDC, length = 0x0006A0 /* boot ROM */
    RESET      : origin = 0x3FFFC0, length = 0x000002 /* boot ROM */
}

SECTIONS
{
    codestart     : > ENTRY

    /* The fast library's division is part of the interrupt. */
    .TI.ramfunc   : { *(.TI.ramfunc) -l rts2800_fpu32_fast_supplement_eabi.lib(.text) } > L0_L3,
                    LOAD_START(ramfunc_load_start), LOAD_SIZE(ramfunc_load_size), RUN_START(ramfunc_run_start)

    .text         : >> L0_L3 | L4_L7
    .cinit        : > L4_L7
    .init_array   : > L4_L7
    .switch       : > L4_L7
    .const        : > L4_L7
    .stack        : > M0_M1
    .bss          : > L4_L7
    .data         : > L4_L7
    .sysmem       : > L4_L7

    FPUmathTables : > FPU_TABLES, TYPE = NOLOAD
    .reset        : > RESET, TYPE = DSECT
}
