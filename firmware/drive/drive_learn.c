/* What is learnt of motor and inverter: sums in every period, and in every so-manieth, each in a period of
 * its own, what they teach. */
#include "drive/drive.h"

/* From the middle of the periods of a mean to their end [s]. */
#define TO_MIDDLE (0.5f * (float)(DRIVE_LEARN_PERIODS - 1u) * DRIVE_PERIOD)

/* So many periods after the means. */
#define INERTIA_TURN    1u
#define DEAD_TIME_TURN  2u
#define INDUCTANCE_TURN 3u
#define EMF_SHAPE_TURN  4u
#define LEGS_TURN       5u

/* What the speed gains says of the inertia, and what of the current carries the load: the loop is not told of
 * that. */
static void learn_inertia(drive_t *drive)
{
    inertia_t *inertia = &drive->inertia;
    if (drive->manoeuvres.tracking == 0u) {
        inertia_rest(inertia);
        return;
    }
    const inertia_input_t input = {
        .omega_ref = drive->manoeuvres.limits.pole_pairs * drive->demand.omega_m_ref,
        .omega = drive->means.omega,
        .i_q = drive->means.current_rotor.q,
    };
    if (drive->means.unsound != 0u || !manoeuvres_steady(&drive->manoeuvres)) {
        inertia_spoil(inertia);
    }
    inertia_step(inertia, &input);
    chosen_set_load(&drive->estimator, inertia_untold(inertia, input.i_q, drive->doubt.tuning.load_most));
}

/* What the EMF says of the dead time: for the next duties, and the voltage that acts from now on. It takes no
 * more than a frame that turns evenly and like the rotor, forced or tracked: not a catch. */
static void learn_dead_time(drive_t *drive, float link)
{
    if (drive->means.even == 0u) {
        dead_time_learn_pause(&drive->dead_time_learn);
        return;
    }
    const float pole_pairs = drive->manoeuvres.limits.pole_pairs;
    const dead_time_learn_input_t input = {
        .emf = drive->means.emf,
        .current = drive->means.current,
        .omega_e = pole_pairs * drive->omega_m,
        .omega_e_ref = pole_pairs * drive->demand.omega_m_ref,
        .link = link,
    };
    dead_time_learn_step(&drive->dead_time_learn, &input);
    inverter_set_dead_time(&drive->inverter, drive->dead_time_learn.effective);
}

/* What the same says of the shape of the EMF, which the estimator is spared while it tracks. */
static void learn_emf_shape(drive_t *drive)
{
    const dead_time_learn_t *learn = &drive->dead_time_learn;
    emf_shape_t *shape = &drive->emf_shape;
    if (learn->seen > 0.0f && dead_time_learn_is_settled(learn)) {
        const emf_shape_input_t input = {
            .emf_mean = learn->emf_mean,
            .rest = learn->rest,
            .omega_e = drive->manoeuvres.limits.pole_pairs * drive->demand.omega_m_ref,
            .time = learn->seen,
            .taken = drive->emf_shape_share,
        };
        emf_shape_step(shape, &input);
    }
    const float omega = drive->means.omega;
    const float share = drive->manoeuvres.tracking != 0u ? emf_shape_share(omega) : 0.0f;
    drive->emf_shape_share = share;
    drive->emf_shape_voltage = share * shape->tuning.flux_linkage * omega * shape->d;
}

void drive_set_legs(drive_t *drive)
{
    inverter_set_legs(&drive->inverter, frames_inverse_clarke(drive->unequal_legs.voltage.used),
                      frames_inverse_clarke(drive->unequal_legs.resistance.used));
}

/* And what of how the legs differ. */
static void learn_unequal_legs(drive_t *drive)
{
    const dead_time_learn_t *learn = &drive->dead_time_learn;
    if (learn->seen > 0.0f && dead_time_learn_is_settled(learn)) {
        const unequal_legs_input_t input = {learn->rest, learn->current, learn->seen};
        unequal_legs_step(&drive->unequal_legs, &input);
        drive_set_legs(drive);
    }
}

/* What a locked loop without encoder answers to the dither, and the next of it. */
static void learn_inductance(drive_t *drive)
{
    if (!manoeuvres_steady(&drive->manoeuvres)) {
        inductance_rest(&drive->inductance);
        return;
    }
    const inductance_input_t input = {
        .emf = drive->means.emf_rotor,
        .current = drive->means.current_rotor,
        .detector = drive->estimator.estimate.detector,
        .omega_smooth = drive->means.omega,
        .theta = drive->means.theta,
        .sound = drive->means.unsound == 0u,
        .voltage_known = dead_time_learn_is_settled(&drive->dead_time_learn),
    };
    inductance_step(&drive->inductance, &input);
}

/* What the last periods teach, as many periods after the means as the `turn` says. */
static void learn_in_turn(drive_t *drive, uint32_t turn, float link)
{
    if (turn == DEAD_TIME_TURN && drive->dead_time_learn.tuning.rate > 0.0f) {
        learn_dead_time(drive, link);
    } else if (turn == EMF_SHAPE_TURN && drive->emf_shape.tuning.rate > 0.0f) {
        learn_emf_shape(drive);
    } else if (turn == LEGS_TURN && drive->unequal_legs.tuning.rate > 0.0f) {
        learn_unequal_legs(drive);
    } else if (turn == INDUCTANCE_TURN && drive->inductance.tuning.rate > 0.0f) {
        learn_inductance(drive);
    } else if (turn == INERTIA_TURN && drive->inertia.tuning.on != 0u) {
        learn_inertia(drive);
    }
}

void drive_learn(drive_t *drive, const inverter_acted_t *acted)
{
    const estimate_t *estimate = &drive->estimator.estimate;
    const measured_t *measured = &drive->measure.measured;
    sums_t *sums = &drive->sums;
    sums_add(sums, estimate->emf, measured->current, estimate->invalid | (measured->good ^ 1u));
    if (sums->count < DRIVE_LEARN_PERIODS) {
        learn_in_turn(drive, sums->count, acted->link);
        return;
    }
    sums_close(sums, 1.0f / (float)DRIVE_LEARN_PERIODS, estimate->frame.rotation, estimate->omega_smooth,
               TO_MIDDLE, &drive->means);
    drive->means.theta = estimate->frame.theta_e;
    drive->means.even = manoeuvres_even(&drive->manoeuvres) ? 1u : 0u;
}

void drive_learn_pause(drive_t *drive)
{
    const ab_t none = {0.0f, 0.0f};
    inductance_rest(&drive->inductance);
    dead_time_learn_pause(&drive->dead_time_learn);
    drive->emf_shape_voltage = 0.0f;
    drive->emf_shape_share = 0.0f;
    sums_clear(&drive->sums);
    drive->means = (means_t){none, none, {0.0f, 0.0f}, {0.0f, 0.0f}, 0.0f, 0.0f, 0u, 0u};
}
