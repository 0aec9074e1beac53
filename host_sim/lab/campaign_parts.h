/* What the parts of the campaign know of each other. Included by host_sim/lab/campaign*.c only. */
#ifndef HOST_SIM_LAB_CAMPAIGN_PARTS_H
#define HOST_SIM_LAB_CAMPAIGN_PARTS_H

#include "host_sim/lab/campaign.h"
#include "host_sim/lab/promised.h"
#include "host_sim/lab/runner.h"

/* The quantity of this name in a case. */
#define CAMPAIGN_VALUE(drawn, name) ((drawn)->quantities[CAMPAIGN_Q_##name])

/* What follows from the quantities: SI units, peak values, per phase. */
typedef struct {
    double pole_pairs, resistance, inductance_d, inductance_q, flux_linkage; /* [-], [ohm], [H], [H], [Wb] */
    double inertia;                                                          /* [kg m^2] */
    double speed;                                                            /* [rad/s] rated, mechanical */
    double torque;                                                           /* [N m] rated */
    double current;                                                          /* [A] rated */
    double trip;                                                             /* [A] overcurrent_trip */
} campaign_motor_t;

campaign_motor_t campaign_motor(const campaign_case_t *drawn);

/* [A] overcurrent_trip and [rad/s] overspeed_trip of the case. */
double campaign_trip(const campaign_case_t *drawn);
double campaign_overspeed(const campaign_case_t *drawn);

/* Text that grows in a buffer; what does not fit is cut, and `used` is size - 1 then. */
typedef struct {
    char *to;
    size_t size, used;
} campaign_writing_t;
void campaign_say(campaign_writing_t *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
void campaign_say_value(campaign_writing_t *text, const table_row_t *row, double value);

/* campaign_around.c: the scenario with its errors; expectations that end beyond the case's length are left
 * out. */
void campaign_say_around(campaign_writing_t *text, const campaign_case_t *drawn, const char *what);

/* The drive's handover_speed by its rule, of what it believes of the motor [rad/s], mechanical. */
double campaign_handover_speed(const campaign_case_t *drawn);

/* In which a fault is noticed [rad], electrical. */
#define CAMPAIGN_TURN (2.0 * 3.14159265358979323846 * PROMISED_TURN)

/* How long an angle may be wrong [s]. */
#define CAMPAIGN_ANGLE_SECONDS 50e-3

/* Mechanical speed [rad/s] below which a wrong angle need not be noticed within that time: below
 * handover_speed the EMF is too small to tell, of magnets that are weaker than believed up to a larger speed,
 * and a third of an electrical turn takes longer. */
double campaign_blind_speed(const campaign_case_t *drawn);

/* Does control turn with the encoder at this time [s]? */
bool campaign_is_coded(const campaign_case_t *drawn, double time);

/* campaign_judge.c: what is watched of a run. */
#define CAMPAIGN_WATCHED_MAX RIG_TAP_MAX

typedef struct {
    const campaign_case_t *drawn;
    campaign_result_t *result;
    volatile sig_atomic_t stop; /* the run shall end: violated, or asked to */
    const volatile sig_atomic_t *asked;
    uint32_t enabled, fault; /* [-] values of `state` */
    uint32_t run;            /* [-] of `manoeuvre` */
    double trip;             /* [A] limit of the true current */
    double overspeed;        /* [rad/s] overspeed_trip */
    double ceiling;          /* [A] beyond it a true current is not excused */
    double blind;            /* [rad/s] mechanical: a slower rotor does not tell of the fault; 0: none */
    bool uncoded;            /* without the encoder nothing tells of the fault */
    uint32_t excused;        /* bits of invariants that the injected fault breaks by itself */
    uint32_t told;           /* [periods] when it excuses them no more */
    uint32_t notice;         /* [periods] with the bridge on, after which it is told; 0: whenever */
    double per_omega;        /* [rad s/rad] electrical angle of a period per mechanical speed */
    double turned;           /* [rad] electrical, since the fault, or since the bridge came on with it */
    uint32_t over[3];        /* [periods] so long has this phase's current been beyond the limit */
    uint32_t far[3];         /* [periods] likewise beyond the ceiling */
    uint32_t over_off[3];    /* [periods] likewise with all gates off */
    uint32_t wrong;          /* [periods] so long has the angle been wrong */
    uint32_t latched;        /* [periods] since the fault was latched */
    uint32_t gates;          /* now on, bit for bit */
    bool gates_seen;         /* one was on in this period */
    bool reset;              /* the chip was, by a fault that is excused for it */
} campaign_watch_t;

/* Rows that are watched, the floats among the signals first; how many, and how many of them are floats that
 * must be finite. */
uint32_t campaign_watched(uint32_t ids[CAMPAIGN_WATCHED_MAX], uint32_t *floats);

void campaign_watch_begin(campaign_watch_t *watch, const campaign_case_t *drawn, campaign_result_t *result,
                          const volatile sig_atomic_t *asked);
void campaign_watch_sample(void *watch, uint32_t period, const uint32_t *slots, uint32_t count);
void campaign_watch_edge(void *watch, uint64_t tick, uint32_t what, uint32_t value);

/* Bit of sample_flags, as the row's text has it. */
#define CAMPAIGN_LATE_FLAG UINT32_C(8)

/* So many words of the drive's state, the first ones, may have a bit flipped. */
#define CAMPAIGN_STATE_WORDS 768u

/* Bit of an invariant. */
#define CAMPAIGN_BIT(NAME) (UINT32_C(1) << CAMPAIGN_I_##NAME)

#endif
