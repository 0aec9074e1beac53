#include "hal/f28335/qep.h"

#include "hal/f28335/bus.h"
#include "hal/f28335/pwm.h"
#include "hal/hal.h"

/* The counter continues while a debugger halts the CPU, because the shaft may still turn. */
#define QEPCTL_COUNTING ((uint16_t)(QEPCTL_FREE_SOFT(2u) | QEPCTL_PCRM(1u) | QEPCTL_QPEN | QEPCTL_QCLM))
#define QCLR_ALL        0x0FFFu
#define STEP_TOLERANCE                                                                                       \
    ((uint32_t)BOARD_CYCLES_OF_NS(100)) /* [SYSCLK cycles]; the two timers are not read in the same cycle */

static void restart_at_zero(uint32_t count_max, uint16_t control)
{
    bus_write32(&EQEP(QEP_MODULE)->QPOSMAX, count_max);
    bus_write32(&EQEP(QEP_MODULE)->QPOSINIT, 0u);
    bus_write16(&EQEP(QEP_MODULE)->QEPCTL, control | QEPCTL_SWI);
}

bool qep_count_max_check(uint32_t count_max)
{
    return (count_max & 3u) == 3u;
}

void qep_init(uint32_t count_max)
{
    bus_write16(&EQEP(QEP_MODULE)->QDECCTL, QDECCTL_QSRC(0u));
    bus_write16(&EQEP(QEP_MODULE)->QEINT, 0u);
    bus_write32(&EQEP(QEP_MODULE)->QUPRD, PWM_PERIOD);
    restart_at_zero(count_max, QEPCTL_COUNTING);
    bus_write16(&EQEP(QEP_MODULE)->QCLR, QCLR_ALL);
}

void qep_start(void)
{
    bus_write32(&EQEP(QEP_MODULE)->QUTMR, 0u);
    bus_write16(&EQEP(QEP_MODULE)->QEPCTL, QEPCTL_COUNTING | QEPCTL_UTE);
}

void qep_keep_step(uint32_t elapsed)
{
    if (EQEP(QEP_MODULE)->QUTMR - elapsed + STEP_TOLERANCE > UINT32_C(2) * STEP_TOLERANCE) {
        bus_write32(&EQEP(QEP_MODULE)->QUTMR, elapsed);
    }
}

bool qep_take_error(void)
{
    if ((EQEP(QEP_MODULE)->QFLG & QEP_PHE) == 0u) {
        return false;
    }
    bus_write16(&EQEP(QEP_MODULE)->QCLR, QEP_PHE);
    return true;
}

bool hal_set_encoder(uint32_t count_max)
{
    if (!qep_count_max_check(count_max) || !pwm_all_tripped()) {
        return false;
    }
    if (count_max != EQEP(QEP_MODULE)->QPOSMAX) {
        restart_at_zero(count_max, QEPCTL_COUNTING | QEPCTL_UTE);
    }
    return true;
}
