/* Signals: the values that the drive shows, as a table over drive_t. A single copy after drive_step takes the
 * chosen slots; every recorder, debugger and protocol reads only this. */
#ifndef SETTINGS_SIGNALS_H
#define SETTINGS_SIGNALS_H

#include <stddef.h>

#include "contract/capture.h"
#include "contract/table.h"
#include "drive/drive.h"

/* F(id, name, slot of drive_t, unit, text): float
 * U(id, name, slot of drive_t, unit, text): uint32_t
 * I(id, name, slot of drive_t, unit, text): int32_t
 * E(id, name, slot of drive_t, choices, text): int32_t with named values */
#define DRIVE_SIGNALS(F, U, I, E)                                                                            \
    U(2000, period, fast.period, "periods", "PWM periods since the start; the drive's only clock")           \
    E(2001, state, state, DRIVE_STATE_NAMES, "state of the drive")                                           \
    I(2002, fault_reason, fault_reason, "-", "reason of the latched fault; 0: none")                         \
    I(2003, refusal, medium.sequence.refusal, "-", "reason why a request is not executed now; 0: none")      \
    U(2004, fault_period, fault.period, "periods", "period of the latched fault")                            \
    U(2005, faults_later, medium.sequence.faults_later.word[0], "-",                                         \
      "fault bits 0 to 31 of faults after the latched one")                                                  \
    U(2076, faults_later_2, medium.sequence.faults_later.word[1], "-",                                       \
      "fault bits 32 to 63 of faults after the latched one")                                                 \
    U(2006, warnings, medium.guard.warnings.word[0], "-", "fault bits 0 to 31 of the present warnings")      \
    U(2077, warnings_2, medium.guard.warnings.word[1], "-", "fault bits 32 to 63 of the present warnings")   \
    I(2078, fault_present, medium.sequence.fault_present, "-",                                               \
      "reason of a fault whose reset was refused, because its cause is still present; 0: none")              \
    U(2079, faults_seen, log.count, "-", "number of faults since power-on; the drive keeps the last ones")   \
    E(2007, manoeuvre, medium.manoeuvres.now, MANOEUVRE_NAMES, "present manoeuvre of the drive")             \
    U(2008, start_try, medium.manoeuvres.start_try, "-",                                                     \
      "number of this start attempt, from 1; 0: no start was needed")                                        \
    U(2009, lock_losses, medium.manoeuvres.losses.count, "-",                                                \
      "number of times that the rotor was lost and caught again since the bridge came on")                   \
    F(2010, i_a, fast.measure.measured.current_abc.a, "A", "phase current a at t_k, offset removed")         \
    F(2011, i_b, fast.measure.measured.current_abc.b, "A", "phase current b at t_k, offset removed")         \
    F(2012, i_c, fast.measure.measured.current_abc.c, "A",                                                   \
      "phase current c at t_k, offset removed, or from a and b")                                             \
    F(2013, i_alpha, fast.measure.measured.current.alpha, "A", "current in the stationary frame")            \
    F(2014, i_beta, fast.measure.measured.current.beta, "A", "current in the stationary frame")              \
    F(2015, i_d, fast.control.current.d, "A", "direct-axis current")                                         \
    F(2016, i_q, fast.control.current.q, "A", "quadrature-axis current")                                     \
    F(2017, i_d_ref, fast.demand.current.d, "A", "direct-axis current reference")                            \
    F(2018, i_q_ref, fast.demand.current.q, "A", "quadrature-axis current reference")                        \
    F(2020, u_d_ref, fast.current_control.voltage_ref.d, "V",                                                \
      "direct-axis voltage commanded by the current control")                                                \
    F(2021, u_q_ref, fast.current_control.voltage_ref.q, "V",                                                \
      "quadrature-axis voltage commanded by the current control")                                            \
    F(2022, u_d, fast.control.voltage.d, "V", "direct-axis voltage applied from t_k+1")                      \
    F(2023, u_q, fast.control.voltage.q, "V", "quadrature-axis voltage applied from t_k+1")                  \
    F(2024, u_dc, fast.measure.measured.u_dc, "V", "DC-link voltage")                                        \
    F(2025, duty_a, fast.command.duty.a, "-", "duty of leg a from t_k+1")                                    \
    F(2026, duty_b, fast.command.duty.b, "-", "duty of leg b from t_k+1")                                    \
    F(2027, duty_c, fast.command.duty.c, "-", "duty of leg c from t_k+1")                                    \
    F(2030, theta_e, fast.rotor.theta_e, "rad", "electrical angle of the rotor that the drive uses, at t_k") \
    F(2031, omega_e, fast.rotor.omega_e, "rad/s", "electrical speed of the rotor that the drive uses")       \
    F(2032, omega_m, fast.omega_m, "rad/s", "mechanical speed")                                              \
    F(2033, omega_m_ref, fast.demand.omega_m_ref, "rad/s", "mechanical speed reference in use")              \
    F(2035, frame_theta_e, fast.demand.frame.theta_e, "rad", "electrical angle of the frame in use, at t_k") \
    U(2034, encoder_count, fast.measure.measured.encoder_count, "counts", "encoder position at t_k")         \
    F(2040, offset_a, fast.measure.offset.a, "A", "offset of current sensor a, measured at zero current")    \
    F(2041, offset_b, fast.measure.offset.b, "A", "offset of current sensor b, measured at zero current")    \
    F(2045, offset_c, fast.measure.offset.c, "A", "offset of current c, measured at zero current")           \
    F(2042, sink_temperature, fast.measure.measured.sink_temperature, "degC", "heat-sink temperature")       \
    F(2043, motor_temperature, fast.measure.measured.motor_temperature, "degC", "motor winding temperature") \
    U(2044, sample_flags, fast.measure.measured.flags, "-",                                                  \
      "1 tripped, 2 fault line, 4 encoder phase error, 8 late, 16 enable input not active, 32 late too "     \
      "often")                                                                                               \
    F(2050, theta_hat, fast.estimator.estimate.frame.theta_e, "rad",                                         \
      "electrical angle of the estimator at t_k")                                                            \
    F(2051, omega_hat, fast.estimator.estimate.frame.omega_e, "rad/s",                                       \
      "electrical speed of the estimator, k_p term included")                                                \
    F(2052, omega_smooth, fast.estimator.estimate.omega_smooth, "rad/s",                                     \
      "electrical speed of the estimator without the k_p term")                                              \
    U(2053, estimator_invalid, medium.estimate.invalid, "-",                                                 \
      "1 amplitude, 2 detector, 4 current error, 8 speed, 16 sample")                                        \
    F(2054, e_hat_alpha, fast.estimator.observed.emf_hat.alpha, "V",                                         \
      "observed back-EMF, filtered, with its lag")                                                           \
    F(2055, e_hat_beta, fast.estimator.observed.emf_hat.beta, "V",                                           \
      "observed back-EMF, filtered, with its lag")                                                           \
    F(2056, e_alpha, fast.estimator.estimate.emf.alpha, "V", "back-EMF at t_k, lag corrected")               \
    F(2057, e_beta, fast.estimator.estimate.emf.beta, "V", "back-EMF at t_k, lag corrected")                 \
    F(2058, e_amplitude, fast.estimator.estimate.amplitude, "V", "length of the back-EMF")                   \
    F(2059, k_f_alpha, fast.estimator.observed.gain_axis.alpha, "1/A",                                       \
      "equivalent gain of the alpha axis; the vector form has only k_f")                                     \
    F(2060, k_f_beta, fast.estimator.observed.gain_axis.beta, "1/A",                                         \
      "equivalent gain of the beta axis; the vector form has only k_f")                                      \
    F(2061, k_f, fast.estimator.observed.gain, "1/A", "equivalent gain that the compensation uses")          \
    F(2062, i_err_alpha, fast.estimator.observed.current_err.alpha, "A", "observed minus measured current")  \
    F(2063, i_err_beta, fast.estimator.observed.current_err.beta, "A", "observed minus measured current")    \
    F(2064, detector, fast.estimator.estimate.detector, "-",                                                 \
      "detector of the tracking loop: sine of its error")                                                    \
    F(2065, psi_f_hat, medium.flux.flux_linkage, "Wb", "adapted flux linkage of the feed-forward")           \
    F(2066, u_alpha, fast.acted.voltage.alpha, "V", "voltage on the winding from t_k-1 to t_k")              \
    F(2067, u_beta, fast.acted.voltage.beta, "V", "voltage on the winding from t_k-1 to t_k")                \
    F(2070, trim_alpha, medium.offset_trim.offset.alpha, "A",                                                \
      "offset of the current sensors, found while turning")                                                  \
    F(2071, trim_beta, medium.offset_trim.offset.beta, "A",                                                  \
      "offset of the current sensors, found while turning")                                                  \
    F(2072, inductance_hat, medium.inductance.learnt.value, "H", "learnt L_q")                               \
    F(2073, inductance_confidence, medium.inductance.confidence, "-",                                        \
      "share of the last measurements of L that agreed with the previous one within a fifth")                \
    F(2074, dead_time_hat, fast.acted.leg, "V", "learnt voltage that a leg loses by dead time and drops")    \
    F(2120, emf_shape_d_hat, medium.ripple.emf_shape.used.d, "-",                                            \
      "learnt sixth harmonic of e_d divided by the EMF: sum of the fifth and seventh harmonic of a phase")   \
    F(2125, emf_shape_q_hat, medium.ripple.emf_shape.used.q, "-",                                            \
      "learnt sixth harmonic of e_q divided by the EMF: seventh minus fifth harmonic of a phase")            \
    F(2121, leg_voltage_alpha_hat, medium.ripple.unequal_legs.voltage.used.alpha, "V",                       \
      "learnt difference of the legs' lost voltage, alpha")                                                  \
    F(2122, leg_voltage_beta_hat, medium.ripple.unequal_legs.voltage.used.beta, "V",                         \
      "learnt difference of the legs' lost voltage, beta")                                                   \
    F(2123, leg_resistance_alpha_hat, medium.ripple.unequal_legs.resistance.used.alpha, "ohm",               \
      "learnt difference of the legs' resistance, alpha")                                                    \
    F(2124, leg_resistance_beta_hat, medium.ripple.unequal_legs.resistance.used.beta, "ohm",                 \
      "learnt difference of the legs' resistance, beta")                                                     \
    F(2075, inertia_hat, medium.inertia.learnt.value, "kg m^2", "learnt inertia of everything that turns")   \
    F(2169, theta_sigma, medium.trust.sigma.sigma, "rad",                                                    \
      "standard deviation that the drive expects of theta_e; 1.8138: the angle is unknown")                  \
    F(2110, resistance_hat, medium.inductance.resistance.value, "ohm", "learnt R of a phase and its device") \
    F(2090, motor_heat, medium.thermal.motor_heat, "-",                                                      \
      "heat of the motor by its current; 1: that of a continuous motor_current_continuous")                  \
    F(2091, module_heat, medium.thermal.module_heat, "-",                                                    \
      "heat of the module's warmest leg; 1: that of a continuous module_current_continuous")                 \
    F(2092, i_q_lower, fast.bounds.lower, "A", "lower limit of i_q by heat, supply and DC link")             \
    F(2093, i_q_upper, fast.bounds.upper, "A", "upper limit of i_q by heat, supply and DC link")             \
    F(2096, speed_calm, medium.manoeuvres.run.calm, "-",                                                     \
      "factor on the bandwidth of the speed control; below 1: reduced because it oscillated")                \
    F(2094, dc_swing, medium.link.watch.ripple, "V",                                                         \
      "largest minus smallest DC-link voltage in the last 20 ms")                                            \
    F(2097, torque_current, medium.manoeuvres.run.torque, "A",                                               \
      "torque reference divided by 1.5 p psi_f, before the limits by heat, supply and DC link")              \
    U(2098, field_weakened, medium.manoeuvres.run.weakening.weakens, "-",                                    \
      "1: the field is weakened, because the DC link limits the voltage")                                    \
    F(2099, voltage_trim, medium.manoeuvres.run.weakening.trim, "-",                                         \
      "relative correction of the voltage by field weakening")                                               \
    F(2130, observer_gain_used, medium.background.in_force.observer_gain, "V",                               \
      "observer_gain in use: the parameter, or its rule if that is 0")                                       \
    F(2131, observer_slope_used, medium.background.in_force.observer_slope, "1/A",                           \
      "observer_slope in use: the parameter, or its rule if that is 0")                                      \
    F(2132, pll_bandwidth_used, medium.background.in_force.pll_bandwidth, "rad/s",                           \
      "pll_bandwidth in use: the parameter, or its rule if that is 0")                                       \
    F(2133, feedforward_cutoff_used, medium.background.in_force.feedforward_cutoff, "rad/s",                 \
      "feedforward_cutoff in use: the parameter, or its rule if pll_bandwidth is 0 too")                     \
    F(2134, handover_speed_used, medium.background.in_force.handover_speed, "rad/s",                         \
      "handover_speed in use: the parameter, or its rule if that is 0")                                      \
    E(2144, commission_state, medium.commission.state, COMMISSION_STATE_NAMES,                               \
      "state of the requested step of commissioning")                                                        \
    E(2145, commission_reason, medium.commission.reason, COMMISSION_REASON_NAMES,                            \
      "why the step ended without a result")                                                                 \
    I(2146, commission_detail, medium.commission.detail, "-",                                                \
      "open_phase: its number; noise, sensor_stuck: number of the sensor; sensor_map: thousands and "        \
      "hundreds the legs of "                                                                                \
      "sensors a and b, tens and units 1 for a wrong sign; no_standstill_angle: 1 the axis is known "        \
      "without its polarity, 2 the ripple brings a phase current to zero")                                   \
    F(2147, commission_largest, medium.commission.largest, "A", "largest current of the step, vector")       \
    F(2148, commission_noise, medium.commission.results.noise, "A", "noise of a current sensor, rms")        \
    F(2149, commission_inductance_pulse, medium.commission.results.inductance_pulse, "H",                    \
      "first value of L, by pulses")                                                                         \
    F(2150, commission_resistance, medium.commission.results.resistance, "ohm",                              \
      "measured R of a phase and its device; 0: not measured")                                               \
    F(2151, commission_resistance_spread, medium.commission.results.resistance_spread, "-",                  \
      "largest difference of that R between two directions, relative")                                       \
    F(2152, commission_dead_voltage, medium.commission.results.dead_voltage, "V",                            \
      "measured voltage that a leg loses by dead time and drops")                                            \
    F(2153, commission_current_hold, medium.commission.results.current_hold, "A",                            \
      "largest current of the standing motor in these steps")                                                \
    F(2199, commission_current_zone, medium.commission.results.current_zone, "A",                            \
      "measured half width of the passage of a leg's loss through zero current")                             \
    F(2154, commission_inductance_d, medium.commission.results.inductance_d, "H", "measured L_d")            \
    F(2155, commission_inductance_q, medium.commission.results.inductance_q, "H", "measured L_q")            \
    F(2200, commission_saturation_current, medium.commission.results.saturation_current, "A",                \
      "measured i_q at which the flux of the q axis is 1/sqrt 2 of L_q i_q; 1e6: none is seen")              \
    F(2221, commission_loop_gain, medium.commission.results.loop_gain, "-",                                  \
      "measured gain of the current loop over its design")                                                   \
    F(2346, commission_angle, medium.commission.results.angle_d, "rad",                                      \
      "measured direction of the d axis of a held rotor, electrical; valid while the step `angle` is done")  \
    F(2156, commission_flux_first, medium.commission.results.flux_first, "Wb",                               \
      "first value of psi_f, by a swing of the rotor")                                                       \
    F(2157, commission_inertia_first, medium.commission.results.inertia_first, "kg m^2",                     \
      "first value of J, by a swing of the rotor")                                                           \
    F(2158, commission_flux_linkage, medium.commission.results.flux_linkage, "Wb", "measured psi_f")         \
    F(2159, commission_flux_scatter, medium.commission.results.flux_scatter, "-",                            \
      "standard deviation of psi_f between windows, relative")                                               \
    F(2160, commission_inertia, medium.commission.results.inertia, "kg m^2", "measured J")                   \
    F(2161, commission_inertia_scatter, medium.commission.results.inertia_scatter, "-",                      \
      "standard error of the fit of J, relative")                                                            \
    F(2162, commission_friction_coulomb, medium.commission.results.friction_coulomb, "N m",                  \
      "measured dry friction")                                                                               \
    F(2163, commission_friction_viscous, medium.commission.results.friction_viscous, "N m s/rad",            \
      "measured friction that grows with speed")                                                             \
    F(2347, commission_point_x, medium.commission.results.point.x, "-",                                      \
      "x of the newest measured point: current, number, speed or torque, by the step")                       \
    F(2348, commission_point_y, medium.commission.results.point.y, "-",                                      \
      "y of the newest measured point: voltage, L, psi_f, EMF or acceleration")                              \
    U(2165, fast_cycles, fast_took.last, "cycles",                                                           \
      "CPU cycles of the last but one sample interrupt, from its entry until its writes")                    \
    U(2166, fast_cycles_max, fast_took.longest, "cycles", "largest value of fast_cycles since the start")    \
    U(2167, medium_cycles, medium_took.last, "cycles",                                                       \
      "CPU cycles from the begin to the end of the last medium task, with the interrupts during it")         \
    U(2168, medium_cycles_max, medium_took.longest, "cycles",                                                \
      "largest value of medium_cycles since the start")                                                      \
    U(2095, coasting, medium.found.coasting, "-", "1: the bridge is off until the lost supply is back")      \
    F(2315, supply_current, medium.link.supply.current, "A",                                                 \
      "mean current from the supply into the inverter, negative into the supply; 0 without "                 \
      "supply_current_max and supply_current_regen_max")                                                     \
    U(2252, outputs, fast.command.outputs, "-", "outputs of the board: 1 chopper on, 2 brake released")      \
    F(2253, chopper_heat, medium.outputs.chopper.heat, "-",                                                  \
      "heat of the brake resistor; 1: that of a continuous chopper_power")                                   \
    E(2254, brake_state, medium.outputs.brake.state, BRAKE_STATE_NAMES, "state of the holding brake")        \
    F(2068, encoder_theta_e, fast.shaft.position.theta_e, "rad", "electrical angle of the encoder at t_k")   \
    F(2069, encoder_omega_e, fast.shaft.position.omega_e, "rad/s", "electrical speed of the encoder")

extern const table_t signals_table;

/* The id of each signal as a constant, SIGNAL_ID_name. */
#define SIGNAL_CONSTANTS(id, name, slot, unit_or_choices, text) SIGNAL_ID_##name = (id),
enum { DRIVE_SIGNALS(SIGNAL_CONSTANTS, SIGNAL_CONSTANTS, SIGNAL_CONSTANTS, SIGNAL_CONSTANTS) };
#undef SIGNAL_CONSTANTS

/* The rows whose history the drive keeps for a fault unless its capture is armed for others:
 * the rows that explain a fault. */
#define DRIVE_HISTORY(S)                                                                                     \
    S(state)                                                                                                 \
    S(i_a) S(i_b) S(u_dc) S(i_d) S(i_q) S(i_q_ref) S(u_d) S(u_q) S(theta_e) S(omega_e) S(sample_flags)

/* The capture ends with the period of the fault. */
extern const capture_wish_t signals_history;

#endif
