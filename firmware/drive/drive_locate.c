/* Where the rotor is: the middle of the pipeline, between measuring and judging. */
#include "drive/drive.h"

#include "math/trig.h"

/* Is what acted too uncertain to track by? */
static inline bool doubtful(drive_t *drive, const inverter_acted_t *acted)
{
    const estimate_t *last = &drive->estimator.estimate;
    const doubt_input_t input = {
        .current = acted->current,
        .leg = acted->leg,
        .amplitude = last->amplitude,
        .detector = last->detector,
        .omega_e = last->frame.omega_e,
        .omega_m = drive->omega_m,
        .omega_m_miss = drive->demand.omega_m_ref - drive->omega_m,
    };
    return doubt_step(&drive->doubt, &input);
}

/* The estimate at t_k while the loop tracks, and what can be learnt of it. */
static void track(drive_t *drive, const inverter_acted_t *acted)
{
    const measured_t *measured = &drive->measure.measured;
    const estimate_t *estimate = &drive->estimator.estimate;
    if (doubtful(drive, acted)) {
        (void)chosen_coast(&drive->estimator, acted->voltage, measured->current);
    } else {
        (void)chosen_step(&drive->estimator, acted->voltage, measured->current);
    }
    if (drive->flux.tuning.share > 0.0f && estimate->coasted == 0u) {
        flux_step(&drive->flux, estimate->amplitude, estimate->omega_smooth, estimate->detector);
        chosen_set_flux(&drive->estimator, drive->flux.flux_linkage, drive->flux.speed_per_volt);
    }
    (void)offset_trim_step(&drive->offset_trim, estimate->emf_hat, estimate->frame.theta_e,
                           estimate->omega_smooth, &measured->current);
}

/* What the speed gains says of the inertia, and what of the current carries the load: the loop is not told of
 * that. */
static void learn_inertia(drive_t *drive)
{
    const estimate_t *estimate = &drive->estimator.estimate;
    const inertia_input_t input = {
        .omega_ref = drive->manoeuvres.limits.pole_pairs * drive->demand.omega_m_ref,
        .omega = estimate->omega_smooth,
        .i_q = frames_park(drive->measure.measured.current, estimate->frame.rotation).q,
    };
    if (drive->inertia.under_way != 0u && (!manoeuvres_judged(&drive->manoeuvres) ||
                                           estimate->invalid != 0u || drive->measure.measured.good == 0u)) {
        inertia_spoil(&drive->inertia);
    }
    inertia_step(&drive->inertia, &input);
    chosen_set_load(&drive->estimator, drive->inertia.load);
}

/* What the EMF says of the dead time: for the next duties, and the voltage that acts from now on. It takes no
 * more than a frame that turns like the rotor, forced or tracked: not a catch. */
static void learn_dead_time(drive_t *drive, const inverter_acted_t *acted)
{
    if (!manoeuvres_knows(&drive->manoeuvres)) {
        dead_time_learn_pause(&drive->dead_time_learn);
        return;
    }
    dead_time_learn_add(&drive->dead_time_learn, drive->estimator.estimate.emf, acted->current);
    if (drive->period % DRIVE_LEARN_PERIODS == DRIVE_LEARN_PERIODS / 2u) {
        const float pole_pairs = drive->manoeuvres.limits.pole_pairs;
        const dead_time_learn_input_t input = {
            .omega_e = pole_pairs * drive->omega_m,
            .omega_e_ref = pole_pairs * drive->demand.omega_m_ref,
            .link = acted->link,
        };
        dead_time_learn_step(&drive->dead_time_learn, &input);
        inverter_set_dead_time(&drive->inverter, drive->dead_time_learn.effective);
    }
}

static void estimate(drive_t *drive)
{
    const measured_t *measured = &drive->measure.measured;
    const inverter_acted_t acted = inverter_acted(&drive->inverter, measured->current, measured->u_dc);
    drive->acted = acted.voltage;
    drive->dead_voltage = acted.leg;
    if (drive->manoeuvres.tracking != 0u) {
        track(drive, &acted);
        if (drive->inertia.tuning.on != 0u) {
            learn_inertia(drive);
        }
    } else {
        inertia_rest(&drive->inertia);
        chosen_observe(&drive->estimator, acted.voltage, measured->current,
                       manoeuvres_speed(&drive->manoeuvres));
    }
    if (drive->dead_time_learn.tuning.rate > 0.0f) {
        learn_dead_time(drive, &acted);
    }
}

void drive_locate(drive_t *drive)
{
    drive->encoder_position = encoder_step(&drive->encoder, drive->measure.measured.encoder_count);
    if (drive->manoeuvres.limits.sensorless == 0u) {
        drive->encoder_frame = (frame_t){drive->encoder_position.theta_e, drive->encoder_position.omega_e,
                                         trig_turn(drive->encoder_position.theta_e)};
    }
    manoeuvres_advance(&drive->manoeuvres);
    if (drive->estimating != 0u) {
        estimate(drive);
    }
    drive->rotor = manoeuvres_rotor(&drive->manoeuvres, &drive->encoder_frame, &drive->estimator.estimate);
    drive->omega_m = manoeuvres_smooth(&drive->manoeuvres, &drive->rotor, &drive->estimator.estimate) *
                     drive->manoeuvres.limits.pole_pairs_inverse;
}
