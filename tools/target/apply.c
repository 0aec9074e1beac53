/* What the background does with interrupts off, on a target, for tools/cost to count: parameters changed with
 * the bridge on and off, a request, the background's look. app.c and hal/ as they are; the registers are
 * memory, whose accesses are calls here, where they are single stores on silicon. 0: all went as on the chip.
 */
#include <stdio.h>

#include "app/app.h"
#include "hal/f28335/bus.h"

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

bool bus_flash_erase(uint16_t sectors)
{
    (void)sectors;
    return false;
}

bool bus_flash_program(uint32_t address, uint16_t word)
{
    (void)address;
    (void)word;
    return false;
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

int main(void)
{
    params_error_t why;
    app = &application;
    params_defaults(&app->staged);
    app->active = app->staged;
    drive_init(&app->drive, &app->active);
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
    return good && app->drive.offered != 0u ? 0 : 1;
}
