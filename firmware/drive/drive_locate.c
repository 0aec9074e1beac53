/* Where the rotor is: the middle of the pipeline, between measuring and judging. */
#include "drive/drive.h"

#include "adapt/emf_shape.h"
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
        .load = drive->inertia.load,
        .gained = inertia_gained(&drive->inertia, drive->means.omega),
        .foreseen = inertia_foreseen(&drive->inertia),
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

static void estimate(drive_t *drive)
{
    const measured_t *measured = &drive->measure.measured;
    inverter_acted_t acted = inverter_acted(&drive->inverter, measured->current, measured->u_dc);
    drive->acted = acted.voltage;
    drive->dead_voltage = acted.leg;
    if (drive->emf_shape_voltage != 0.0f) {
        const ab_t shape =
            emf_shape_voltage(drive->emf_shape_voltage, drive->estimator.estimate.frame.rotation);
        acted.voltage.alpha -= shape.alpha;
        acted.voltage.beta -= shape.beta;
    }
    if (drive->manoeuvres.tracking != 0u) {
        track(drive, &acted);
    } else {
        chosen_observe(&drive->estimator, acted.voltage, measured->current,
                       manoeuvres_speed(&drive->manoeuvres));
    }
    if (drive->learns != 0u) {
        drive_learn(drive, &acted);
    }
}

void drive_locate(drive_t *drive)
{
    drive->encoder_position = encoder_step(&drive->encoder, drive->measure.measured.encoder_count);
    if (drive->manoeuvres.sensorless == 0u) {
        drive->encoder_frame = (frame_t){drive->encoder_position.theta_e, drive->encoder_position.omega_e,
                                         trig_turn(drive->encoder_position.theta_e)};
    }
    manoeuvres_advance(&drive->manoeuvres);
    if (drive->estimating != 0u) {
        estimate(drive);
    }
    drive_believe(drive);
}

void drive_believe(drive_t *drive)
{
    drive->rotor = manoeuvres_rotor(&drive->manoeuvres, &drive->encoder_frame, &drive->estimator.estimate);
    drive->omega_m = manoeuvres_smooth(&drive->manoeuvres, &drive->rotor, &drive->estimator.estimate) *
                     drive->manoeuvres.limits.pole_pairs_inverse;
}
