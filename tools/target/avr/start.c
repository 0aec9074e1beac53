/* Console, exit, and functions that avr-libc does not have. The three registers are described in simulator.c.
 */
#include <avr/io.h>
#include <math.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* exit() of avr-libc ends in a loop; this one gives the exit code to the simulator. */
void exit(int code)
{
    GPIOR1 = (uint8_t)code;
    for (;;) {
    }
}

static signal_handler_t on_abort;

signal_handler_t signal(int number, signal_handler_t handler)
{
    const signal_handler_t before = on_abort;
    (void)number;
    on_abort = handler;
    return before;
}

void abort(void)
{
    if (on_abort != SIG_DFL) {
        on_abort(SIGABRT);
    }
    exit(134);
}

static int put(char character, FILE *stream)
{
    (void)stream;
    GPIOR0 = (uint8_t)character;
    return 0;
}

static int get(FILE *stream)
{
    (void)stream;
    return GPIOR2;
}

/* The start-up code jumps to exit after main, so that the result of main becomes the exit code. */
__attribute__((constructor)) static void open_console(void)
{
    static FILE console = FDEV_SETUP_STREAM(put, get, _FDEV_SETUP_RW);
    stdin = &console;
    stdout = &console;
    stderr = &console;
}

/* ---- <math.h> ---- */

float nextafterf(float from, float to)
{
    uint32_t bits;
    if (isnan(from) || isnan(to) || from == to) {
        return isnan(from) ? from : to;
    }
    memcpy(&bits, &from, sizeof bits);
    if (from == 0.0f) {
        bits = to > 0.0f ? UINT32_C(1) : UINT32_C(0x80000001);
    } else if ((from > 0.0f) == (to > from)) {
        bits++;
    } else {
        bits--;
    }
    memcpy(&from, &bits, sizeof from);
    return from;
}

double expm1(double x)
{
    const double power = exp(x);
    if (power == 1.0) {
        return x;
    }
    return fabs(x) > 0.5 ? power - 1.0 : (power - 1.0) * x / log(power);
}

double atanh(double x)
{
    return 0.5 * log((1.0 + x) / (1.0 - x));
}

double nearbyint(double x)
{
    if (!(fabs(x) < 8388608.0)) {
        return x;
    }
    const double whole = floor(x);
    const double rest = x - whole;
    return rest > 0.5 || (rest == 0.5 && fmod(whole, 2.0) != 0.0) ? whole + 1.0 : whole;
}

double remainder(double x, double y)
{
    return x - y * nearbyint(x / y);
}
