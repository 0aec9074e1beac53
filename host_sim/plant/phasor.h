/* Angle functions of the plant in double precision, by polynomials, with the same bits on every machine. They
 * are independent of those of the firmware. Errors below 2e-16 plus rounding unless stated. */
#ifndef HOST_SIM_PLANT_PHASOR_H
#define HOST_SIM_PLANT_PHASOR_H

#define PHASOR_PI     3.14159265358979323846
#define PHASOR_TWO_PI 6.28318530717958647692

/* cos and sin of an angle [rad], |theta| <= 1e5 (the error grows with it, 1e-16 |theta|). */
void phasor_at(double theta, double *cosine, double *sine);

/* exp(-x), x >= 0, relative error below 1e-15; 0 above 700. */
double phasor_decay(double x);

/* Rotates (cosine, sine) by a small angle [rad], |delta| <= 0.11: truncation below 1e-14. */
static inline void phasor_turn(double *cosine, double *sine, double delta)
{
    double x = delta * delta;
    double s = delta * (1.0 + x * (-1.0 / 6.0 + x * (1.0 / 120.0 - x * (1.0 / 5040.0))));
    double c = 1.0 - x * (0.5 - x * (1.0 / 24.0 - x * (1.0 / 720.0 - x * (1.0 / 40320.0))));
    double cos_0 = *cosine;
    double sin_0 = *sine;
    *cosine = cos_0 * c - sin_0 * s;
    *sine = sin_0 * c + cos_0 * s;
}

#endif
