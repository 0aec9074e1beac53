/* The tables of the simulation, with the same form as those of the drive: truth (true values of the plant,
 * which the drive does not get), plant (what the plant is made of) and rig (fidelity and injected faults). */
#ifndef HOST_SIM_RIG_RIG_TABLES_H
#define HOST_SIM_RIG_RIG_TABLES_H

#include "contract/table.h"
#include "host_sim/plant/plant.h"
#include "host_sim/rig/rig.h"

/* F(id, name, unit, text): float */
#define RIG_TRUTH(F)                                                                                         \
    F(3000, true_theta_e, "rad", "rotor angle at t_k, electrical, wrapped")                                  \
    F(3001, true_omega_e, "rad/s", "rotor speed at t_k, electrical")                                         \
    F(3002, true_omega_m, "rad/s", "rotor speed at t_k, mechanical")                                         \
    F(3003, true_torque, "N m", "air-gap torque at t_k")                                                     \
    F(3004, true_i_a, "A", "phase current a at t_k")                                                         \
    F(3005, true_i_b, "A", "phase current b at t_k")                                                         \
    F(3006, true_i_c, "A", "phase current c at t_k")                                                         \
    F(3007, true_i_d, "A", "direct-axis current at t_k")                                                     \
    F(3008, true_i_q, "A", "quadrature-axis current at t_k")                                                 \
    F(3009, true_u_dc, "V", "DC-link voltage at t_k")                                                        \
    F(3010, theta_err, "rad", "angle that the drive used minus true_theta_e, wrapped")                       \
    F(3011, shoot_throughs, "-", "number of times that both switches of a leg conducted")                    \
    F(3012, chip_reports, "-", "number of wrong uses that the chip reported")                                \
    F(3013, theta_hat_err, "rad", "angle of the estimator minus true_theta_e, wrapped")                      \
    F(3014, true_supply_current, "A",                                                                        \
      "mean current from the source into a link with a capacitor, over the period before t_k")

typedef struct {
#define TRUTH_FIELD(id, name, unit, text) float name; /* [unit of its row] */
    RIG_TRUTH(TRUTH_FIELD)
#undef TRUTH_FIELD
} rig_truth_t;

/* The plant's parameters as 32-bit slots; ids count from 4000 in the order of PLANT_PARAMS, which is append
 * only. */
typedef struct {
#define PLANT_FIELD(name, unit, initial, min, max, text) float name; /* [unit of its row] */
    PLANT_PARAMS(PLANT_FIELD)
#undef PLANT_FIELD
} rig_plant_t;

/* F(id, name, unit, default, min, max, text): float; E(id, name, choices, text): named values */
#define RIG_CONDITIONS(F, E)                                                                                 \
    E(5000, fidelity, "switched|averaged",                                                                   \
      "switched: every gate edge; averaged: mean voltages, for long runs")                                   \
    F(5001, interrupt_delay, "s", 0.0f, 0.0f, 1e-3f, "added to the entry time of the sample interrupt")      \
    F(5002, stuck_current_a, "-", -1.0f, -1.0f, 4095.0f,                                                     \
      "code that the ADC has for current a, independent of the current; -1: no fault")                       \
    F(5003, stuck_current_b, "-", -1.0f, -1.0f, 4095.0f,                                                     \
      "code that the ADC has for current b, independent of the current; -1: no fault")                       \
    F(5004, stuck_dc_link, "-", -1.0f, -1.0f, 4095.0f,                                                       \
      "code that the ADC has for the DC link; -1: no fault")                                                 \
    E(5005, metering, "off|on", "energy meters of the plant; they slow the simulation down")                 \
    E(5006, sensors, "adc|exact",                                                                            \
      "exact: the drive gets the true currents and DC link of t_k, without sensor errors and ADC")           \
    F(5007, stuck_current_c, "-", -1.0f, -1.0f, 4095.0f,                                                     \
      "code that the ADC has for current c, if that has a sensor; -1: no fault")                             \
    F(5008, interrupt_time, "-", 1.0f, 0.0f, 20.0f,                                                          \
      "time between reading the samples and writing the outputs in the interrupt, relative to its "          \
      "estimated cost on the chip")                                                                          \
    F(5009, section_time, "-", 1.0f, 0.0f, 10000.0f,                                                         \
      "time for which the background disables interrupts, relative to its estimate for a change of "         \
      "parameters")                                                                                          \
    F(5010, background_time, "s", 2e-6f, 0.0f, 1.0f, "least time between two runs of the background")        \
    F(5011, brake_torque, "N m", 0.0f, 0.0f, 1e3f,                                                           \
      "brake on the shaft: slows it like dry friction, then holds it; 0: released")                          \
    F(5012, estimate_jump, "rad", 0.0f, -3.1415927f, 3.1415927f,                                             \
      "added once to the electrical angle of the estimator's loop; after that, or after a start of the "     \
      "bridge, the value is 0 again")                                                                        \
    F(5013, missing_samples, "-", 0.0f, 0.0f, 10000.0f,                                                      \
      "number of the next conversions that fail, with their interrupts; then the value is 0 again")          \
    F(5014, flip_bit, "-", 0.0f, 0.0f, 31.0f, "number of the bit that flip_word changes")                    \
    F(5015, flip_word, "-", -1.0f, -1.0f, 65535.0f,                                                          \
      "index of a 32-bit word in which bit flip_bit is changed once; then the value is -1 again. The words " \
      "are the state of the drive, the staged, and the active parameters, in this order, repeated")          \
    E(5016, flip_memory, "none|flash|code_in_ram|stack_end|params",                                          \
      "memory of the chip, or the active parameters, in which bit flip_bit mod 16 of a word is changed "     \
      "once; then the value is none again")                                                                  \
    F(5017, medium_time, "-", 1.0f, 0.0f, 100.0f,                                                            \
      "time of the medium task, without its interruptions, relative to its estimated cost on the chip")      \
    E(5047, enable_input, "active|lost",                                                                     \
      "level of the board's enable input; a board without this input accepts only active")

typedef struct {
#define CONDITION_FLOAT(id, name, unit, initial, min, max, text) float name;   /* [unit of its row] */
#define CONDITION_ENUM(id, name, choices, text)                  int32_t name; /* [-] */
    RIG_CONDITIONS(CONDITION_FLOAT, CONDITION_ENUM)
#undef CONDITION_FLOAT
#undef CONDITION_ENUM
} rig_conditions_t;

extern const table_t truth_table;
extern const table_t plant_table;
extern const table_t conditions_table;

plant_params_t rig_plant_params(const rig_plant_t *values);

#endif
