#include "host_sim/lab/times.h"

#include "host_sim/rig/rig.h"

#define EXACT_DECIMALS  9u                    /* of a whole number of nanoseconds */
#define PERIOD_DECIMALS 18u                   /* of a period's length */
#define PERIOD_UNITS    UINT64_C(20000000000) /* [1e-18 s] three ticks' 20 ns */

/* value x 10^-decimals, at least one of them. Returns the length. */
static size_t write_decimal(char *to, uint64_t value, uint32_t decimals)
{
    char digits[TIMES_TEXT_SIZE];
    size_t count = 0;
    while (value != 0u || count <= decimals) {
        digits[count++] = (char)('0' + value % 10u);
        value /= 10u;
    }
    size_t length = 0;
    while (count > 0u) {
        to[length++] = digits[--count];
        if (count == decimals) {
            to[length++] = '.';
        }
    }
    return length;
}

/* Takes zeros off the end of value x 10^-decimals. */
static void shorten(uint64_t *value, uint32_t *decimals)
{
    while (*decimals > 1u && *value % 10u == 0u) {
        *value /= 10u;
        --*decimals;
    }
}

uint64_t times_nanoseconds(uint64_t tick)
{
    return (tick * 20u + 1u) / 3u;
}

size_t times_write(char *to, uint32_t period, uint64_t period_ticks)
{
    uint64_t time = times_nanoseconds(period * period_ticks);
    uint64_t length = times_nanoseconds(period_ticks);
    uint32_t decimals = EXACT_DECIMALS;
    if (period_ticks % 3u == 0u) {
        shorten(&length, &decimals);
    }
    for (uint32_t n = decimals; n < EXACT_DECIMALS; n++) {
        time /= 10u;
    }
    return write_decimal(to, time, decimals);
}

const char *times_text(char to[TIMES_TEXT_SIZE], uint32_t period)
{
    to[times_write(to, period, RIG_PERIOD_TICKS)] = '\0';
    return to;
}

double times_seconds(uint32_t period, uint64_t period_ticks)
{
    return (double)times_nanoseconds(period * period_ticks) / 1e9;
}

const char *times_period_text(char to[TIMES_TEXT_SIZE], uint64_t period_ticks)
{
    uint64_t length = (period_ticks * PERIOD_UNITS + 1u) / 3u;
    uint32_t decimals = PERIOD_DECIMALS;
    shorten(&length, &decimals);
    to[write_decimal(to, length, decimals)] = '\0';
    return to;
}
