/* Formats of the fixed-point estimator: the only table. U, I are the bases of voltage and current, powers of
 * two in volt and ampere that fixed.c chooses for the motor, so that per-unit values are SI values shifted; T
 * is the period. Every number is an int32_t (q.h) unless stated otherwise.
 *
 *   quantity                        base          Q    range     resolution
 *   voltage, EMF                    U             27   +-16      7.5e-9      samples and EMF within +-4
 *   current, its error              I             25   +-64      3.0e-8      samples within +-16, error +-8
 *   angle                           a turn        32   wraps     1.5e-9 rad
 *   speed: angle in a period        a turn / T    31   +-1       2.9e-9 rad
 *   integrator, feed-forward        a turn / T    63   +-1       int64_t: no dead zone
 *   K: acceleration per current     turn / T^2 I  38   +-1/128   3.6e-12
 *   sine, cosine, detector, tanh    1             30   +-2       9.3e-10
 *   k_s/U, b k_s                    1             30   +-2       9.3e-10
 *   b                               I / U         30   +-2       9.3e-10
 *   b R, the hold's small terms     1             32   +-1/2     2.3e-10
 *   R, g, 2/b, L/T                  U / I         24   +-128     6.0e-8
 *   k_f                             1 / I         24   +-128     6.0e-8
 *   k_f of one axis, for show       1 / I         20   +-2048    9.5e-7
 *   a_f/2, k_s a_f/2                1 / I, U / I  26   +-32      1.5e-8
 *   a_f/2 times current             1             22   +-512     2.4e-7
 *   f x, x x and their means        I, I^2        26   +-16      1.5e-8      31 bits more in the means
 *   speed per volt                  turn / T U    30   0..1      9.3e-10     31 bits more while it adapts
 *   shares of low-passes            1             31   0..1      4.7e-10     the loop's EMF filter: 30
 *
 * The formats are chosen so that most products of the interrupt are the upper word of 64 bits: b u (Q30 Q27)
 * and b R i (Q32 Q25) meet in Q57, whose upper word is Q25; the speed is the upper word of its integrators.
 *
 * For the paper's motor (k_s = 200 V, L = 12.5 mH, T = 100 us): U = 256 V, I = 2 A; so voltages resolve 2 uV,
 * currents 60 nA, speeds 30 urad/s. */
#ifndef ESTIMATOR_FIXED_FORMATS_H
#define ESTIMATOR_FIXED_FORMATS_H

#define VOLTAGE_Q        27
#define CURRENT_Q        25
#define ANGLE_Q          32
#define SPEED_Q          31
#define LONG_SPEED_Q     63
#define UNIT_Q           30
#define GAIN_Q           30
#define SMALL_Q          32
#define IMPEDANCE_Q      24
#define AXIS_GAIN_Q      20
#define SLOPE_Q          26
#define STRETCHED_Q      22
#define SPEED_PER_VOLT_Q 30
#define SHARE_Q          31

/* Samples and EMF in counts: +-4 U, +-16 I; and as a number of bits. */
#define SAMPLE_BITS    29
#define SAMPLE_LARGEST (INT32_C(1) << SAMPLE_BITS)

/* Switching voltage and e_hat, which are at most k_s: +-2 U. */
#define SWITCHED_BITS    28
#define SWITCHED_LARGEST (INT32_C(1) << SWITCHED_BITS)

/* The current error: +-8 I. */
#define ERROR_LARGEST ((INT32_C(1) << 28) - 1)

#endif
