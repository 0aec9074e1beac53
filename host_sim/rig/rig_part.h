/* A rig as one of the two parts of the closed loop: the drive, or the plant. The cut is at drive_step. The
 * drive is the program: interrupts, background, and the time that they take. The plant is the rest: the
 * peripherals of the chip with the functions of the HAL, inverter, motor and sensors. Each part is a whole
 * rig of which the other part stays as it was at the cut.
 *
 * The parts exchange the rows of rig_exchange_table() once in a period: the sample of the plant, which the
 * drive takes in the same period, and the command of the drive. The new duties act from the next carrier zero
 * on, gates and outputs at the instant of the command. Therefore both parts need no more than one exchange in
 * each period, and together have the bits of the ring:
 *
 *     rig_part_sample(plant)
 *     for each period: sample to the drive; rig_part_step(drive); command to the plant; rig_part_step(plant);
 *                      rig_part_sample(plant)
 *
 * One value may come too late: if the power module trips within the period, the gates are off at once,
 * because the trip zone belongs to the plant. But the drive has already run this period without the trip
 * interrupt. A caller that needs the bits of the ring also then sets trip_time, and repeats the period of the
 * drive.
 *
 * Not exchanged: a reset of the chip, and an interrupt that does not end in its period. */
#ifndef HOST_SIM_RIG_RIG_PART_H
#define HOST_SIM_RIG_RIG_PART_H

#include "host_sim/rig/rig.h"

typedef enum { RIG_RING, RIG_DRIVE, RIG_PLANT } rig_part_t;

/* F(id, name, unit, default, min, max, text): float; N(id, name, unit, default, max, text): whole number;
 * E(id, name, choices, text): named values */
#define RIG_COMMAND(F, N, E)                                                                                 \
    F(6000, command_duty_a, "-", 0.5f, 0.0f, 1.0f, "high time of leg a over the next period")                \
    F(6001, command_duty_b, "-", 0.5f, 0.0f, 1.0f, "high time of leg b over the next period")                \
    F(6002, command_duty_c, "-", 0.5f, 0.0f, 1.0f, "high time of leg c over the next period")                \
    E(6003, command_gates, "keep|on|off",                                                                    \
      "on: release the trip zone, so that the gates follow the duties; off: trip it; keep: no change")       \
    E(6004, command_chopper, "off|on", "output of the brake chopper, if the board has it")                   \
    E(6005, command_brake, "off|on", "output that releases the holding brake, if the board has it")          \
    F(6006, command_time, "s", 0.0f, -1.0f, 1.0f,                                                            \
      "time from the beginning of the period until these values are written; negative: nothing is written")  \
    F(6007, command_dead_time, "s", 0.0f, 0.0f, 1e-3f,                                                       \
      "parameter dead_time of the drive; a change acts while the gates are off")                             \
    N(6008, command_encoder_lines, "-", 0, 1000000,                                                          \
      "parameter encoder_lines of the drive; a change acts while the gates are off")

#define RIG_SAMPLE(F, N, E)                                                                                  \
    F(6020, sample_i_a, "A", 0.0f, -1e6f, 1e6f, "current of phase a at t_k, as the sensor measures it")      \
    F(6021, sample_i_b, "A", 0.0f, -1e6f, 1e6f, "current of phase b at t_k, as the sensor measures it")      \
    F(6022, sample_i_c, "A", 0.0f, -1e6f, 1e6f,                                                              \
      "current of phase c at t_k; with two sensors the negative sum of the others")                          \
    F(6023, sample_u_dc, "V", 0.0f, -1e6f, 1e6f, "voltage of the DC link, as the sensor measures it")        \
    F(6024, sample_sink_temperature, "degC", 25.0f, -273.15f, 1e6f, "heat sink; -273.15: no sensor")         \
    F(6025, sample_motor_temperature, "degC", 25.0f, -273.15f, 1e6f, "winding; -273.15: no sensor")          \
    N(6026, sample_encoder, "counts", 0, INT32_MAX, "position of the encoder at t_k, 0 to 4 lines - 1")      \
    E(6027, sample_tripped, "no|yes", "the trip zone holds the gates off")                                   \
    E(6028, sample_fault_line, "no|yes", "the fault output of the power module is active")                   \
    E(6029, sample_encoder_error, "no|yes", "phase error of the encoder since the last sample")              \
    E(6030, sample_late, "no|yes", "the sample came too late")                                               \
    E(6031, sample_not_enabled, "no|yes", "the enable input of the board is not active")                     \
    F(6032, trip_time, "s", -1.0f, -1.0f, 1.0f,                                                              \
      "time from the beginning of the last period until the module tripped within it; negative: it did not")

/* The rows that the parts exchange; true: the row belongs to the command of the drive. */
const table_t *rig_exchange_table(void);
bool rig_exchange_is_command(const table_row_t *row);

/* Makes a new rig one of the parts. All settings before t = 0 come first. */
void rig_part_cut(rig_t *rig, rig_part_t part);

/* Value of a row of the exchange. rig_exchange_set: the row accepts the value. */
double rig_exchange_get(const rig_t *rig, const table_row_t *row);
void rig_exchange_set(rig_t *rig, const table_row_t *row, double value);

/* One period: the drive runs it with the present sample; the plant writes the present command, and runs to
 * the end of the period. rig_part_sample: the plant runs the coming period until its sample is there; no
 * effect on the other part. */
void rig_part_step(rig_t *rig);
void rig_part_sample(rig_t *rig);

/* What a state needs in addition to rig_save. */
size_t rig_part_state_size(void);
void rig_part_save(const rig_t *rig, void *state);
void rig_part_load(rig_t *rig, const void *state);

#endif
