#include "hal/f28335/pwm.h"

#include "hal/f28335/adc.h"
#include "hal/f28335/bus.h"
#include "hal/f28335/clock.h"

#define FIRST PWM_LEADER
#define LAST  ((uint16_t)(PWM_LEADER + 2u))

/* Delay of the sync pulse to the next module [cycles]. A follower loads this count, which is then the
 * leader's. */
#define SYNC_DELAY 2u

/* When a debugger halts the CPU, the carrier stops at the end of its period: at counter zero all legs apply
 * the zero vector. The chip cannot open the gates at a halt, because a halt is none of its six trip inputs.
 * In real-time mode a halt of the background also stops the carrier and the interrupts, unless the debugger
 * has written FREE_SOFT = 2 before. With this value the carrier runs on in every halt; in a halt without
 * real-time mode it repeats the last duties. */
#define TBCTL_COMMON   ((uint16_t)(TBCTL_CTRMODE(TBCTL_UPDOWN) | TBCTL_FREE_SOFT(1u)))
#define TBCTL_LEADER   ((uint16_t)(TBCTL_COMMON | TBCTL_SYNCOSEL(1u)))
#define TBCTL_FOLLOWER ((uint16_t)(TBCTL_COMMON | TBCTL_PHSEN | TBCTL_PHSDIR_UP))
#define TZSEL_WORD     TZSEL_OSHT((uint16_t)BOARD_TRIP_ZONE)
#define ETSEL_WORD     ((uint16_t)(ETSEL_SOCASEL(ET_CMPB_DOWN) | ETSEL_SOCAEN))

/* Action of output A when the counter passes CMPA, and the CMPA for a high time of `count`. */
#if BOARD_SAMPLES_AT == BOARD_UPPER_ZERO_VECTOR
#define AQCTLA_WORD       ((uint16_t)(AQCTL_CAU(AQ_CLEAR) | AQCTL_CAD(AQ_SET)))
#define COMPARE_OF(count) (count)
#else
#define AQCTLA_WORD       ((uint16_t)(AQCTL_CAU(AQ_SET) | AQCTL_CAD(AQ_CLEAR)))
#define COMPARE_OF(count) ((uint16_t)(HAL_PERIOD_COUNT - (count)))
#endif

#if HAL_GATE_ACTIVE_HIGH
#define DBCTL_WORD ((uint16_t)(DBCTL_OUT_BOTH | DBCTL_POLSEL_AHC))
#define TZCTL_WORD ((uint16_t)(TZCTL_TZA(TZ_LOW) | TZCTL_TZB(TZ_LOW)))
#else
#define DBCTL_WORD ((uint16_t)(DBCTL_OUT_BOTH | DBCTL_POLSEL_ALC))
#define TZCTL_WORD ((uint16_t)(TZCTL_TZA(TZ_HIGH) | TZCTL_TZB(TZ_HIGH)))
#endif

static void set_up_leg(uint16_t n, uint16_t dead_band_count)
{
    const volatile epwm_regs_t *leg = EPWM(n);

    bus_write16(&leg->TBCTL, n == FIRST ? TBCTL_LEADER : TBCTL_FOLLOWER);
    bus_write16(&leg->TBPHS, n == FIRST ? 0u : SYNC_DELAY);
    bus_write16(&leg->TBCTR, 0u);
    bus_write16(&leg->TBPRD, HAL_PERIOD_COUNT);
    bus_write16(&leg->CMPCTL, (uint16_t)(CMPCTL_LOADAMODE(0u) | CMPCTL_LOADBMODE(0u)));
    bus_write16(&leg->CMPA, COMPARE_OF((uint16_t)(HAL_PERIOD_COUNT / 2u)));
    bus_write16(&leg->CMPB, n == FIRST ? ADC_LEAD : 0u);
    bus_write16(&leg->AQCTLA, AQCTLA_WORD);
    bus_write16(&leg->AQCTLB, 0u);
    bus_write16(&leg->AQCSFRC, 0u);
    bus_write16(&leg->DBRED, dead_band_count);
    bus_write16(&leg->DBFED, dead_band_count);
    bus_write16(&leg->DBCTL, DBCTL_WORD);
    bus_allow();
    bus_write16(&leg->TZSEL, TZSEL_WORD);
    bus_write16(&leg->TZCTL, TZCTL_WORD);
    bus_write16(&leg->TZEINT, 0u);
    bus_protect();
    bus_write16(&leg->ETSEL, n == FIRST ? ETSEL_WORD : 0u);
    bus_write16(&leg->ETPS, n == FIRST ? ETPS_SOCAPRD(1u) : 0u);
}

/* true: the registers that prevent a shoot-through, and those of the trip zone, still have their values. */
static bool leg_is_safe(uint16_t n)
{
    const volatile epwm_regs_t *leg = EPWM(n);

    return leg->DBCTL == DBCTL_WORD && leg->DBRED >= HAL_DEAD_BAND_MIN && leg->DBFED >= HAL_DEAD_BAND_MIN &&
           leg->TZSEL == TZSEL_WORD && leg->TZCTL == TZCTL_WORD;
}

static bool any_trip_flag(void)
{
    return (EPWM(FIRST)->TZFLG | EPWM(FIRST + 1u)->TZFLG | EPWM(LAST)->TZFLG) != 0u;
}

bool pwm_any_tripped(void)
{
    return ((EPWM(FIRST)->TZFLG | EPWM(FIRST + 1u)->TZFLG | EPWM(LAST)->TZFLG) & TZ_OST) != 0u;
}

bool pwm_all_tripped(void)
{
    return (EPWM(FIRST)->TZFLG & EPWM(FIRST + 1u)->TZFLG & EPWM(LAST)->TZFLG & TZ_OST) != 0u;
}

bool pwm_fault_line(void)
{
    return (GPIO_DATA(0u)->DAT & GPIO_PIN(PWM_FAULT_PIN)) == 0u;
}

uint32_t pwm_elapsed(void)
{
    const uint32_t counter = EPWM(FIRST)->TBCTR;

    return (EPWM(FIRST)->TBSTS & TBSTS_CTRDIR) != 0u ? counter : PWM_PERIOD - counter;
}

bool pwm_init(uint16_t dead_band_count)
{
    uint16_t n;

    for (n = FIRST; n <= LAST; n++) {
        set_up_leg(n, dead_band_count);
    }
    hal_gates_off();
    return pwm_all_tripped();
}

void hal_gates_off(void)
{
    bus_allow();
    bus_write16(&EPWM(FIRST)->TZEINT, 0u);
    bus_write16(&EPWM(FIRST)->TZFRC, TZ_OST);
    bus_write16(&EPWM(FIRST + 1u)->TZFRC, TZ_OST);
    bus_write16(&EPWM(LAST)->TZFRC, TZ_OST);
    bus_protect();
}

bool hal_gates_on(void)
{
    const bool armed = (EPWM(FIRST)->TZEINT & TZ_OST) != 0u;
    uint16_t n;

    if (armed && !any_trip_flag()) {
        return true;
    }
    if (!clock_carrier_runs() || pwm_fault_line() || !leg_is_safe(FIRST) || !leg_is_safe(FIRST + 1u) ||
        !leg_is_safe(LAST)) {
        return false;
    }
    bus_allow();
    for (n = FIRST; n <= LAST; n++) {
        bus_write16(&EPWM(n)->TZCLR, TZ_OST | TZ_INT);
    }
    bus_write16(&EPWM(FIRST)->TZEINT, TZ_OST);
    bus_protect();
    /* A fault since the test above has set the flags again. */
    if (any_trip_flag()) {
        hal_gates_off();
        return false;
    }
    return true;
}

static uint16_t at_most_full(uint16_t count)
{
    return count <= HAL_PERIOD_COUNT ? count : HAL_PERIOD_COUNT;
}

void hal_write_compare(uint16_t a, uint16_t b, uint16_t c)
{
    bus_write16(&EPWM((uint16_t)BOARD_LEG_A)->CMPA, COMPARE_OF(at_most_full(a)));
    bus_write16(&EPWM((uint16_t)BOARD_LEG_B)->CMPA, COMPARE_OF(at_most_full(b)));
    bus_write16(&EPWM((uint16_t)BOARD_LEG_C)->CMPA, COMPARE_OF(at_most_full(c)));
}

bool hal_set_dead_band(uint16_t count)
{
    uint16_t n;

    if (count < HAL_DEAD_BAND_MIN || count > HAL_DEAD_BAND_MAX || !pwm_all_tripped()) {
        return false;
    }
    for (n = FIRST; n <= LAST; n++) {
        bus_write16(&EPWM(n)->DBRED, count);
        bus_write16(&EPWM(n)->DBFED, count);
    }
    return true;
}
