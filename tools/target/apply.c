/* Runs the work of the background on a simulated target, where tools/cost counts the instructions. With
 * interrupts off: a change of parameters with the bridge on and off, a request, and the self-check. Then each
 * task of the list in its longest case, talk_step with each command of a client, the orders except those of
 * the memory, and the steps that write a set into a memory on the I2C bus. app.c and hal/ are unchanged. The
 * registers are memory, and each access is a function call, while it is a single store on the chip. Exit
 * status: 0 if every step had the expected result.
 */
#include <stdio.h>

#include "app/app.h"
#include "hal/f28335/bus.h"
#include "settings/signals.h"
#include "talk/mirror.h"
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

/* The memory is blank and stays blank. */
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

/* All legs are tripped, as while the bridge is off. */
static void trip(void)
{
    for (uint16_t n = 1u; n <= 6u; n++) {
        bus_write16(&EPWM(n)->TZFLG, 0xFFFFu);
    }
}

/* Runs each task several times: when the self-test is due, when a value was learnt, and with the bridge on
 * and off. */
static void run_list(void)
{
    for (uint32_t n = 0u; n < 40u; n++) {
        app->drive.fast.period += 1000u;
        app->assumed.inertia *= 0.9f;
        app->drive.state = (int32_t)(n % 2u == 0u ? DRIVE_READY : DRIVE_OPERATION_ENABLED);
        app_background();
    }
}

/* Gives the background a complete command of a client, in the form of the serial line. */
static void send(const uint8_t *packet, uint32_t count)
{
    static uint32_t counter;
    uint8_t frame[FRAMES_MOST];
    const uint32_t octets = frames_make(frame, packet, count, counter, true);
    talk_in_t *came = &app->talk.came;
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

/* The commands of a client that reads and sets values; of each kind the longest. */
static bool talk(void)
{
    static const uint8_t connect[] = {0xFF, 0};
    static const uint8_t status[] = {0xFD};
    uint8_t upload[] = {0xF4, 60, 0, APP_TABLE_SIGNALS, 0, 0, 0, 0};
    uint8_t place[] = {0xF6, 0, 0, APP_TABLE_PARAMS, 0, 0, 0, 0};
    uint8_t download[] = {0xF0, 4, 0, 0, 0, 0};
    uint8_t checksum[] = {0xF3, 0, 0, 0, 0, 0, 0, 0};
    const table_row_t *last = &params_table.rows[params_table.count - 1u];
    talk_start();
    send(connect, sizeof connect);
    send(status, sizeof status);
    frames_put_long(&upload[4], 4u * signals_table.rows[signals_table.count - 20u].id);
    send(upload, sizeof upload);
    frames_put_long(&place[4], 4u * last->id);
    frames_put_long(&download[2], table_bits(last, &app->staged));
    send(place, sizeof place);
    send(place, sizeof place); /* an address and a value take effect only when they were received twice */
    send(download, sizeof download);
    send(download, sizeof download);
    frames_put_long(&place[4], 4u * params_table.rows[0].id);
    frames_put_long(&checksum[4], 4u * (last->id - params_table.rows[0].id) < XCP_CHECKSUM_MAX
                                      ? 4u * (last->id - params_table.rows[0].id)
                                      : XCP_CHECKSUM_MAX);
    send(place, sizeof place);
    send(place, sizeof place);
    send(checksum, sizeof checksum);
    return app->talk.receiver.frames == 10u && app->talk.receiver.errors == 0u;
}

/* ---- orders ---- */

static bool order(order_t what)
{
    params_error_t why;
    return services_write(SERVICE_ORDER, (uint32_t)what, &why);
}

static bool run_orders(void)
{
    app->drive.state = (int32_t)DRIVE_READY;
    app->staged = app->active;
    app->staged.speed_kp *= 0.9f;
    (void)order(ORDER_LOAD); /* The memory is empty, so that the drive reads it and refuses the order. */
    (void)order(ORDER_CAPTURE_ARM);
    return order(ORDER_APPLY) && order(ORDER_CAPTURE_RELEASE) && order(ORDER_DEFAULTS);
}

/* ---- a memory on the I2C bus, which this board does not have: the work of parameters_step() on a board with
 * one ---- */

#define MEMORY_WORDS 280u /* offset of a page in the mirror */

static uint16_t memory[2u * MEMORY_WORDS], mirrored[2u * MEMORY_WORDS];
static uint32_t read_from, bus_clock;

static void memory_write(uint32_t at, const uint16_t *words, uint32_t count)
{
    for (uint32_t n = 0u; n < count; n++) {
        memory[at + n] = words[n];
    }
}

static void memory_read(uint32_t at)
{
    read_from = at;
}

static mirror_reply_t memory_poll(uint16_t words[MIRROR_GROUP])
{
    for (uint32_t n = 0u; n < MIRROR_GROUP; n++) {
        words[n] = memory[read_from + n];
    }
    return MIRROR_DONE;
}

static void memory_give_up(void)
{
}

static uint32_t memory_time(void)
{
    return bus_clock++;
}

static bool run_memory(void)
{
    static const mirror_bus_t bus = {memory_write, memory_read, memory_poll,  memory_give_up, memory_time,
                                     1000u,        1000u,       MEMORY_WORDS, MEMORY_WORDS};
    static const uint16_t words[16] = {1u, 2u, 3u};
    mirror_t mirror;
    mirror_begin(&mirror);
    while (mirror_step(&mirror, &bus, mirrored)) {
    }
    bool good = mirror_erase(&mirror, &bus, mirrored, 0u);
    while (mirror_step(&mirror, &bus, mirrored)) {
    }
    good = mirror_program(&mirror, &bus, mirrored, 0u, 3u, words, 16u) && good;
    while (mirror_step(&mirror, &bus, mirrored)) {
    }
    return good && mirror.error == (uint32_t)MIRROR_GOOD && memory[5] == 3u;
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
    app->staged.dead_time *= 1.5f; /* with the bridge off the registers change as well */
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
    good = run_orders() && good;
    good = run_memory() && good;
    return good ? 0 : 1;
}
