/* What the background does, on a target, for tools/cost to count. With interrupts off: parameters changed
 * with the bridge on and off, a request, the background's look. And each task of its list, with what makes it
 * long, and talk_step with each command of a client. app.c and hal/ as they are; the registers are memory,
 * whose accesses are calls here, where they are single stores on silicon. 0: all went as on the chip. */
#include <stdio.h>

#include "app/app.h"
#include "hal/f28335/bus.h"
#include "settings/signals.h"
#include "tests/rig/frames.h"

static uint32_t registers[0x4000];
const volatile uint16_t *f28335_base = (const volatile uint16_t *)registers;

static app_t application;

uint16_t bus_read16(const volatile uint16_t *reg)
{
    return *reg;
}

void bus_write16(const volatile uint16_t *reg, uint16_t value)
{
    *(volatile uint16_t *)reg = value;
}

void bus_write32(const volatile uint32_t *reg, uint32_t value)
{
    *(volatile uint32_t *)reg = value;
}

uint32_t bus_vector(bus_isr_t isr)
{
    return (uint32_t)isr;
}

void bus_allow(void)
{
}

void bus_protect(void)
{
}

void bus_enable_group(uint16_t group)
{
    (void)group;
}

void bus_request_group(uint16_t group)
{
    (void)group;
}

void bus_disable_groups(void)
{
}

void bus_clear_pending(void)
{
}

void bus_interrupts_enable(void)
{
}

void bus_interrupts_disable(void)
{
}

/* Blank, and left so. */
uint16_t bus_flash(uint32_t address)
{
    (void)address;
    return 0xFFFFu;
}

bus_memory_t bus_flash_api(void)
{
    return (bus_memory_t){NULL, 0u};
}

uint16_t *bus_code_ram(void)
{
    return NULL;
}

void bus_copy_code(void)
{
}

bus_function_t bus_function_at(uint32_t address)
{
    (void)address;
    return NULL;
}

void bus_debug_allow(void)
{
}

void bus_debug_groups(uint16_t mask)
{
    (void)mask;
}

bus_memory_t bus_memory(bus_region_t region)
{
    static const uint16_t words[64];
    (void)region;
    return (bus_memory_t){words, 64u};
}

uint16_t bus_otp(uint32_t address)
{
    (void)address;
    return 0u;
}

void bus_wait(uint32_t cycles)
{
    (void)cycles;
}

/* All legs tripped, as they are while the bridge is off. */
static void trip(void)
{
    for (uint16_t n = 1u; n <= 6u; n++) {
        bus_write16(&EPWM(n)->TZFLG, 0xFFFFu);
    }
}

/* Each task several times: the self-test is due, a value was learnt, and the bridge is on and off. */
static void run_list(void)
{
    for (uint32_t n = 0u; n < 40u; n++) {
        app->drive.fast.period += 1000u;
        app->believed.inertia *= 0.9f;
        app->drive.state = (int32_t)(n % 2u == 0u ? DRIVE_READY : DRIVE_OPERATION_ENABLED);
        app_background();
    }
}

/* A command as a client sends it on the serial line, given to the background whole. */
static void send(const uint8_t *packet, uint32_t count)
{
    static uint32_t counter;
    uint8_t frame[FRAMES_MOST];
    const uint32_t octets = frames_make(frame, packet, count, counter, true);
    talk_ring_t *came = &app->talk.came;
    counter++;
    for (uint32_t n = 0u; n < octets; n++) {
        came->octets[came->put] = frame[n];
        came->put = (uint16_t)((came->put + 1u) % TALK_RING);
    }
    for (uint32_t n = 0u; n < 6u; n++) { /* the command, then its answer in pieces */
        app->talk.going.got = app->talk.going.put;
        talk_step();
    }
}

/* The commands of a client that reads and sets, and the longest of each kind. */
static bool talk(void)
{
    static const uint8_t connect[] = {0xFF, 0};
    static const uint8_t status[] = {0xFD};
    uint8_t upload[] = {0xF4, 60, 0, APP_TABLE_SIGNALS, 0, 0, 0, 0};
    uint8_t place[] = {0xF6, 0, 0, APP_TABLE_PARAMS, 0, 0, 0, 0};
    uint8_t download[] = {0xF0, 4, 0, 0, 0, 0};
    const table_row_t *last = &params_table.rows[params_table.count - 1u];
    talk_start();
    send(connect, sizeof connect);
    send(status, sizeof status);
    frames_put_long(&upload[4], 4u * signals_table.rows[signals_table.count - 20u].id);
    send(upload, sizeof upload);
    frames_put_long(&place[4], 4u * last->id);
    frames_put_long(&download[2], table_bits(last, &app->staged));
    send(place, sizeof place);
    send(download, sizeof download);
    send(download, sizeof download); /* a number acts when it was received twice */
    return app->talk.receiver.frames == 6u && app->talk.receiver.errors == 0u;
}

int main(void)
{
    params_error_t why;
    app = &application;
    params_defaults(&app->staged);
    app->active = app->staged;
    drive_init(&app->drive, &app->active);
    app->drive.fast.period = 1u; /* the interrupt runs */
    trip();

    bool good = true;
    app->staged.dead_time *= 1.5f; /* with the bridge off registers change, too */
    app->staged.encoder_lines /= 2;
    app->staged.speed_kp *= 0.9f;
    good = app_apply(&why) && good;

    app->drive.state = (int32_t)DRIVE_OPERATION_ENABLED;
    app->staged.speed_kp *= 0.9f;
    good = app_apply(&why) && good;

    requests_t requests = app->drive.requests;
    requests.speed_request = 1.0f;
    good = app_request(&requests, &why) && good;
    app->task = 0u;
    app_background();
    printf("%s\n", good ? "applied" : why.rule);
    good = good && app->drive.offered != 0u;
    run_list();
    good = talk() && good;
    return good ? 0 : 1;
}
