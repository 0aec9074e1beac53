/* What the parts of the campaign know of each other. Included by host_sim/lab/campaign*.c only. */
#ifndef HOST_SIM_LAB_CAMPAIGN_PARTS_H
#define HOST_SIM_LAB_CAMPAIGN_PARTS_H

#include <string.h>

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
    double saturation; /* [A] current at which the q axis saturates; 0: it does not */
    double fastest;    /* [-] largest speed that is requested over SPEED_DRAWN of the rated one */
} campaign_motor_t;

campaign_motor_t campaign_motor(const campaign_case_t *drawn);

/* [A] overcurrent_trip and [rad/s] overspeed_trip of the case. */
double campaign_trip(const campaign_case_t *drawn);
double campaign_overspeed(const campaign_case_t *drawn);

/* [-] The speed of an event over the rated one. */
double campaign_speed_of(const campaign_case_t *drawn, const campaign_event_t *event);

/* Is it one of the motors that are drawn by the stream of their own? */
bool campaign_is_salient(const campaign_case_t *drawn);

/* [-] Configured over true L. */
double campaign_inductance_configured(const campaign_case_t *drawn);

/* [kg m^2] Of all that turns. */
double campaign_inertia(const campaign_case_t *drawn);

/* Load beside friction and load_torque, over rated torque: fan, sine and spring at their largest. */
double campaign_load(const campaign_case_t *drawn);

/* Is no fault injected? Around a scenario nobody knows. */
bool campaign_is_healthy(const campaign_case_t *drawn);

/* Can the load drive the motor? */
bool campaign_overhauls(const campaign_case_t *drawn);

/* Is it healthy, with a load that cannot overhaul the motor, no current asked for and no step of the load
 * that take it beyond overspeed_trip, a supply away from its limits, and a link that the rotor cannot fill?
 */
bool campaign_is_calm(const campaign_case_t *drawn);

/* campaign_rows.c: what is set at t = 0. */
typedef struct {
    const table_row_t *row;
    double value; /* [unit of the row] */
} campaign_setting_t;

#define CAMPAIGN_SETTINGS_MAX 96u

typedef struct {
    campaign_setting_t settings[CAMPAIGN_SETTINGS_MAX];
    uint32_t count;
} campaign_settings_t;

void campaign_set_all(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor);
double campaign_loop(const campaign_case_t *drawn);       /* [rad/s] pll_bandwidth */
double campaign_speed_loop(const campaign_case_t *drawn); /* [rad/s] of the speed control, by its rule */
/* campaign_space.c: offsets that drift while the bridge is on are a fault, and not meant: such an event goes.
 */
void campaign_drop_drifts(campaign_case_t *drawn);

bool campaign_has_encoder(const campaign_case_t *drawn);

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

/* The drive's handover_speed by its rule, of the configured motor [rad/s], mechanical. */
double campaign_handover_speed(const campaign_case_t *drawn);

/* In which a fault is noticed [rad], electrical. */
#define CAMPAIGN_TURN (2.0 * 3.14159265358979323846 * PROMISED_TURN)

/* How long an angle may be wrong [s]. */
#define CAMPAIGN_ANGLE_SECONDS 50e-3

/* Mechanical speed [rad/s] below which a wrong angle need not be noticed within that time: below
 * handover_speed the EMF is too small to tell, of magnets that are weaker than configured up to a larger
 * speed, and a third of an electrical turn takes longer. */
double campaign_blind_speed(const campaign_case_t *drawn);

/* Does control turn with the encoder at this time [s]? */
bool campaign_is_coded(const campaign_case_t *drawn, double time);

/* campaign_judge.c: what is watched of a run. */
#define CAMPAIGN_WATCHED_MAX RIG_TAP_MAX

/* Rows that are judged one by one, in this order behind the floats among the signals; floats come first. */
#define CAMPAIGN_JUDGED_FLOATS(R)                                                                            \
    R(true_i_a)                                                                                              \
    R(true_i_b)                                                                                              \
    R(true_i_c)                                                                                              \
    R(theta_err)                                                                                             \
    R(true_omega_m)                                                                                          \
    R(true_u_dc)                                                                                             \
    R(shoot_throughs)                                                                                        \
    R(chip_reports)                                                                                          \
    R(true_torque)                                                                                           \
    R(omega_m_ref) R(i_d_ref) R(i_q_ref) R(frame_theta_e) R(speed_request) R(i_q_request) R(load_torque)
#define CAMPAIGN_JUDGED(R)                                                                                   \
    CAMPAIGN_JUDGED_FLOATS(R)                                                                                \
    R(state) R(manoeuvre) R(sample_flags) R(enable) R(mode) R(refusal) R(fault_reason) R(coasting)
enum {
#define CAMPAIGN_PLACE(name) CAMPAIGN_AT_##name,
    CAMPAIGN_JUDGED(CAMPAIGN_PLACE)
#undef CAMPAIGN_PLACE
        CAMPAIGN_JUDGED_ROWS
};
#define CAMPAIGN_FLOATS_JUDGED CAMPAIGN_AT_state

/* What an injected fault excuses, and when. */
typedef struct {
    uint32_t bits;   /* of invariants that it breaks by itself */
    uint32_t begins; /* [periods] when it comes */
    uint32_t ends;   /* [periods] when what it broke is right again */
    double ceiling;  /* [A] beyond it a true current is not excused */
    double blind;    /* [rad/s] mechanical: a slower rotor does not tell of the fault; 0: none */
    bool uncoded;    /* without the encoder nothing tells of the fault */
    uint32_t told;   /* [periods] when it excuses them no more */
    uint32_t notice; /* [periods] with the bridge on, after which it is reported; 0: at any time */
    double turned;   /* [rad] electrical, since the fault, or since the bridge came on with it */
    uint32_t far[3]; /* [periods] so long has this phase's current been beyond the ceiling */
} campaign_excused_t;

/* campaign_duty.c: what the drive must do. */
typedef struct {
    double torque, speed, inertia;  /* [N m], [rad/s] rated, [kg m^2] of all that turns */
    double overspeed;               /* [rad/s] beyond it the shaft is too fast */
    double link;                    /* [V] beyond it the link is too high, its sensor's error in it */
    double stop_time;               /* [s] fault_stop_time */
    double load, drag;              /* [-] of rated torque: fan, sine and spring; friction */
    bool drawn, healthy;            /* all of it is drawn; nothing is injected */
    bool limited;                   /* the link limits the torque that holds a speed */
    bool soft;                      /* it limits the torque of braking alone */
    bool brakes;                    /* the present wish is slower than the shaft was, or the other way */
    uint32_t off, fast, high, mute; /* [periods] so long has it been so */
    uint32_t away;                  /* [periods] so long has the torque driven away */
    double away_torque;             /* [N m] largest of that time */
    double away_error;              /* [rad/s] by which the speed was wrong when half of that time began */
    uint32_t away_wish[4];          /* slots of what was asked for meanwhile, and of the load */
    bool coded;                     /* control turns with the encoder throughout */
    double lag;                     /* [s] of the speed of the tracking loop */
    double answer;                  /* [s] in which the speed control answers a change */
    double winding;                 /* [N m/rad] what its integral winds up or down per error and time */
    uint32_t stopping;              /* [periods] since the quick stop began */
    double stop_most;               /* [s] it may take; 0: it is not judged */
    uint32_t wish[4];               /* slots of what was requested last, and of the load */
    double due;                     /* [periods] when the speed must be there, since the wish */
    uint32_t since;                 /* [periods] since the wish has been this one */
    double error;                   /* [rad/s] sum of the present window */
} campaign_duty_t;

/* campaign_reasons.c: what has happened, to which a report is compared. */
typedef struct {
    double fast, over, high, low, under; /* [rad/s], [A], [V]: from there on a reason is true */
    double speed;                        /* [rad/s] mechanical, behind the lag of the tracking loop */
    double none; /* [A] length of a current that is nearly none, as of the drive\'s watch of the encoder */
    uint32_t fast_at, over_at, high_at, low_at, wrong_at; /* [periods] when it was so last; 0: never */
    uint32_t starved;                                     /* [periods] so long has the link been too low */
    uint32_t quiet; /* [periods] so long has no current flowed, with all gates off */
    bool drifted;   /* the offsets have moved since the last time that was long enough to measure them ... */
    bool heavy;     /* a mass behind an elastic shaft may move the motor against its torque */
    bool weak;      /* a magnet is injected whose EMF seems to be missing */
    bool fed;       /* ... and the rotor has fed the link since, so that they could not be measured */
    uint32_t asked[CAMPAIGN_FAULTS_MAX]; /* [periods] in which the fault could be noticed */
    double turned[CAMPAIGN_FAULTS_MAX];  /* [rad] electrical, in those */
    int32_t reason;                      /* [-] that was compared last */
    int32_t shown;                       /* [-] of the last period ... */
    uint32_t shown_at;                   /* [periods] ... and when it came */
} campaign_truth_t;

/* campaign_pair.c: the angle of a run, to be compared with that of the same run without learning. */
#define CAMPAIGN_ANGLE_WINDOWS 512u

typedef struct {
    double blind, rated;                  /* [rad/s] mechanical: slower is not compared; of the motor */
    float square[CAMPAIGN_ANGLE_WINDOWS]; /* [rad^2] mean of each window; below 0: it was not steady */
    uint32_t windows;                     /* that are complete */
    uint32_t wish[4];                     /* slots of what was asked for last, and of the load */
    uint32_t settled;                     /* [periods] since the wish has been this one */
    uint32_t periods;                     /* [periods] of the present window */
    double sum;                           /* [rad^2] of the present window */
    bool steady;                          /* so far */
} campaign_angles_t;

void campaign_angles_begin(campaign_angles_t *angles, const campaign_case_t *drawn);

#define CAMPAIGN_PAIR_SECONDS 10.0 /* [s] so much longer are the runs of a pair */

/* Is this one of the runs that are made with learning and without? */
bool campaign_is_paired(const campaign_case_t *drawn);

/* A violation, if the angle was worse with learning. */
void campaign_compare_angles(const campaign_angles_t *with, const campaign_angles_t *without,
                             campaign_result_t *result);

typedef struct {
    const campaign_case_t *drawn;
    campaign_result_t *result;
    campaign_angles_t *angles;  /* NULL: they are not kept */
    volatile sig_atomic_t stop; /* the run shall end: violated, or asked to */
    const volatile sig_atomic_t *asked;
    campaign_motor_t motor;
    uint32_t ready, enabled, stops, fault; /* [-] values of `state` */
    uint32_t run;                          /* [-] of `manoeuvre` */
    double trip;                           /* [A] limit of the true current */
    double drift;                          /* [A] by which an offset drifts at most while the bridge is off */
    double overspeed;                      /* [rad/s] overspeed_trip */
    double per_omega;                      /* [rad s/rad] electrical angle of a period per mechanical speed */
    campaign_excused_t excused[CAMPAIGN_FAULTS_MAX];
    campaign_duty_t duty;
    campaign_truth_t truth;
    uint32_t over[3];     /* [periods] so long has this phase's current been beyond the limit */
    uint32_t over_off[3]; /* [periods] the same with all gates off */
    uint32_t wrong;       /* [periods] so long has the angle been wrong */
    uint32_t latched;     /* [periods] since the fault was latched */
    uint32_t gates;       /* now on, bit for bit */
    bool gates_seen;      /* one was on in this period */
    double shorts;        /* [-] shoot_throughs of the period before */
    bool reset;           /* the chip was, by a fault that is excused for it */
} campaign_watch_t;

/* The first violation is the one that counts; `since` so many periods, the present one among them. */
void campaign_violated(campaign_watch_t *watch, campaign_invariant_t invariant, uint32_t period,
                       uint32_t since, const char *row);

static inline double campaign_number(const uint32_t *rows, uint32_t place)
{
    float value;
    memcpy(&value, &rows[place], sizeof value);
    return (double)value;
}

/* [periods] of a time. */
static inline uint32_t campaign_periods(double seconds)
{
    return (uint32_t)(seconds / RIG_PERIOD_SECONDS + 0.5);
}

/* Is the fault there in this period? */
bool campaign_is_there(const campaign_watch_t *watch, uint32_t fault, uint32_t period);

void campaign_duty_begin(campaign_watch_t *watch);
void campaign_judge_duty(campaign_watch_t *watch, uint32_t period, const uint32_t *rows);
void campaign_truth_begin(campaign_watch_t *watch);
void campaign_judge_reasons(campaign_watch_t *watch, uint32_t period, const uint32_t *rows);
void campaign_keep_angle(campaign_watch_t *watch, const uint32_t *rows);

/* The value of a row at t = 0, of the scenario that the case is around or by default. */
double campaign_initial(const campaign_case_t *drawn, const char *row);

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
