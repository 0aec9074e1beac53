/* Writes a recording: power-on, a rotor turning at 500 r/min, sensorless start, a speed step to 1000 r/min at
 * 0.3 s, a load step of 5 N m at 0.6 s. The linker passes the interrupt's drive_step through here (--wrap),
 * so what is recorded is what the real interrupt got and gave.
 *
 * usage: record FILE */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "host_sim/rig/rig.h"
#include "tests/target/recording.h"

#define RPM     (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */
#define SECONDS 1.0

static FILE *file;
static uint32_t recorded;

static void put(uint32_t word)
{
    for (uint32_t shift = 0; shift < 32u; shift += 8u) {
        if (putc((int)(word >> shift & 0xFFu), file) == EOF) {
            perror("record");
            exit(3);
        }
    }
}

static void put_words(const void *slots, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        uint32_t word;
        memcpy(&word, (const char *)slots + 4u * n, 4);
        put(word);
    }
}

static void put_table(const table_t *table, const void *base)
{
    for (uint32_t n = 0; n < table->count; n++) {
        put(table_bits(&table->rows[n], base));
    }
}

void __real_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);
void __wrap_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);

void __wrap_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    if (file == NULL || recorded == rig_periods(SECONDS)) {
        __real_drive_step(drive, samples, command);
        return;
    }
    if (recorded++ == 0u) {
        put(RECORDING_MAGIC);
        put(recording_tables());
        put(rig_periods(SECONDS));
        put_table(&params_table, &app->active);
    }
    put_table(&requests_table, &drive->requests);
    put_words(samples, RECORDING_SAMPLES);
    __real_drive_step(drive, samples, command);
    put_table(&signals_table, drive);
    put_words(command, RECORDING_COMMAND);
}

static void until(rig_t *rig, double seconds)
{
    rig_run(rig, rig_periods(seconds) - rig_period(rig));
}

int main(int argc, char **argv)
{
    if (argc != 2 || (file = fopen(argv[1], "wb")) == NULL) {
        fprintf(stderr, "usage: record FILE, which must be writable\n");
        return 2;
    }
    rig_t *rig = rig_create(1);
    bool good = rig != NULL && rig_put(rig, "position_source", 1.0) &&
                rig_put(rig, "torque_feedforward", 1.0) && rig_apply(rig);
    if (good) {
        rig_set_motion(rig, 0.0, 500.0 * RPM);
        good = rig_put(rig, "speed_request", 500.0 * RPM) && rig_put(rig, "enable", 1.0);
        until(rig, 0.3);
        good = good && rig_put(rig, "speed_request", 1000.0 * RPM);
        until(rig, 0.6);
        good = good && rig_put(rig, "load_torque", 5.0);
        until(rig, SECONDS);
        while (recorded < rig_periods(SECONDS)) {
            rig_step(rig); /* the interrupt of the last period */
        }
        printf("%u interrupts, %.1f r/min, %.2f A, fault %g\n", (unsigned)recorded,
               rig_value(rig, "omega_m") / RPM, rig_value(rig, "i_q"), rig_value(rig, "fault_reason"));
        good = good && rig_value(rig, "state") == 3.0 && rig_value(rig, "fault_reason") == 0.0;
    }
    if (!good) {
        fprintf(stderr, "record: the drive did not run as wished: %s\n",
                rig != NULL ? rig_error(rig) : "no memory");
    }
    rig_free(rig);
    return fclose(file) == 0 && good ? 0 : 3;
}
