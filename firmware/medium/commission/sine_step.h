/* Measures L_d and L_q by a sine of voltage in addition to a standing current that is so large that no phase
 * current changes its sign: the loss of the dead time is then constant and has no effect. Over whole periods
 * of the sine, with the voltage that acted and the current of the sample as complex numbers U and I,
 *
 *     I = a z^-1 I + b U,   z = e^(j w T),  a = e^(-r),  r = R T/L
 *
 * a and b are real: two equations. Bandwidth and delay of the control do not matter. b depends on the
 * instants at which the voltage acts. A change U of the mean voltage moves the two edges of each leg, and
 * decays from each edge to the sample at the end of the period. The edges of a leg are half a period apart
 * and symmetrical about the middle, and late by the mean D of their delays (one edge of each leg is late by
 * the dead time):
 *
 *     b = (T/L) (e^(-r/4) + e^(-3r/4))/2 e^(r D/T)     L = (T/b) e^(-r/2) cosh(r/4) e^(r D/T)
 *
 * A voltage that is held for the whole period would have (1 - a)/r. With it L is too small by r D/T, 0.7 % at
 * an L/R of three periods with 2 us, and too large by r^2/96.
 *
 * Saturation of the q axis, psi_q = L_q i/sqrt(1 + (i/I_s)^2): a flux of amplitude F needs the current
 *
 *     i = F/L_q (1 + 3/8 s F^2 + 15/64 s^2 F^4),   s = 1/(L_q I_s)^2      its first harmonic
 *
 * so that two amplitudes give I_s and L_q without current. A motion of the rotor adds the same amount to
 * both.
 *
 * Along the axis the rotor does not move. Across it a free rotor swings with the sine, and its motion adds
 * -1.5 p^2 psi^2/(J w^2) to L_q. Runs at two frequencies eliminate this: L = (L1 w1^2 - L2 w2^2)/(w1^2 -
 * w2^2).
 *
 * Gains of the sensors. The answer of a winding is symmetric: a voltage along alpha causes as much current
 * along beta as a voltage along beta causes along alpha, for a rotor in any direction. If two sensors have
 * the gains 1 + g_a and 1 + g_b, the measured currents are i_alpha (1 + g_a) and i_beta (1 + g_b) + (g_a -
 * g_b) i_alpha/sqrt(3). With y the current across the sine over that along it, in phase,
 *
 *     (g_a - g_b)/sqrt(3) = y_d - y_q L_d/L_q
 *
 * Three sensors have a symmetric error, which is not visible here but in their sum. */
#ifndef MEDIUM_COMMISSION_SINE_STEP_H
#define MEDIUM_COMMISSION_SINE_STEP_H

#include "medium/commission/standing.h"

#define SINE_LINEAR 1e6f /* [A] I_s of a q axis whose L_q does not depend on the current */

/* A complex number. */
typedef struct {
    float re, im;
} sine_sum_t;

/* Adds a window: its sums with the cosine and with the sine of the excitation. */
static inline void sine_sum_add(sine_sum_t *sum, float cosine, float sine)
{
    sum->re += cosine;
    sum->im -= sine;
}

typedef enum { SINE_BEGIN, SINE_ALIGN, SINE_TURN, SINE_STILL, SINE_RUNS } sine_phase_t;

typedef struct {
    int32_t phase;          /* [-] sine_phase_t */
    uint32_t run;           /* [-] of the table of runs */
    uint32_t windows;       /* [windows] of this run */
    uint32_t length;        /* [windows] that this run sums */
    uint32_t lowered;       /* [-] times that the current was lowered */
    float current;          /* largest standing current [A] */
    float guess_d, guess_q; /* L by which the next voltage is chosen [H] */
    float value[7];         /* L of each run [H] */
    float turn_q;           /* w T of the first run across the axis [rad] ... */
    float turn_lower;       /* ... and of the one at a lower frequency [rad] */
    float swing[7];         /* amplitude of the current of each run [A] */
    float beside[7];        /* current across the sine over that along it, in phase, of each run [-] */
    standing_t standing;
    sine_sum_t voltage; /* sums of this run [V], */
    sine_sum_t along;   /* of the current along the sine [A] */
    sine_sum_t across;  /* and across it [A] */
} sine_step_t;

/* L [H] from U and I; `turn`: w T [rad] with its cosine and sine. A result that is not positive means that no
 * L fits. */
float sine_solve(sine_sum_t voltage, sine_sum_t current, rotation_t turn, const commission_tuning_t *tuning);

void sine_step_begin(sine_step_t *step);

commission_verdict_t sine_step(sine_step_t *step, const commission_tuning_t *tuning,
                               const commission_input_t *input, excite_order_t *order,
                               commission_results_t *results);

#endif
