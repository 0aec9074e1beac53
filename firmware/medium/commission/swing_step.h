/* Measures first values of psi_f and J without a steady speed: a current turns the rotor by a third of a
 * turn. They are accurate enough for the rules of a start.
 *
 *     z(t) = int (u - R i - v) dt - L_d (i - i(0))     change of the magnets' flux, by the winding's law;
 *                                                      v: loss of the dead time
 *     |z|^2 = 2 c z                                    z moves on a circle through zero with the centre c:
 *                                                      least squares, psi_f = |c|, Psi_m = z - c
 *     J d omega/dt = 1.5 p (Psi_m x i) - T_c           regression over the motion
 *
 * From the second jump on Psi_m(0) is known. A salient rotor then has its direction from the active flux,
 * Psi - L_q i, which lies on its d axis for every current, and L_d i is taken out on that axis alone.
 * The current is so small that it takes at most half of psi_f from the active flux; beyond psi_f it would
 * turn the rotor away.
 *
 * The circle does not depend on the final angle of the rotor, which friction may keep away from the axis. The
 * resistance across the axis brakes the rotor. If the torque hardly accelerates the rotor for this reason,
 * the jumps are repeated with a larger resistance, which brakes less; J may remain unknown. The regression
 * ends when a jump becomes slow, because friction then has an unknown torque. There are several jumps in both
 * directions. An error of the voltage at rest, which is integrated as well, has opposite signs in the two
 * directions: if it is a third of psi_f, one jump has twice the psi_f of another, and the step ends with
 * `emf_too_small`. A rotor whose direction changes by less than 37 degrees in a jump is held, or too heavy:
 * the step ends with `rotor_not_turning`. */
#ifndef MEDIUM_COMMISSION_SWING_STEP_H
#define MEDIUM_COMMISSION_SWING_STEP_H

#include "medium/commission/standing.h"

/* The flux of the magnets and the torque during a jump. */
typedef struct {
    ab_t flux;                /* int (u - R i - v) dt [Wb] */
    ab_t from;                /* current at the beginning [A] */
    ab_t last;                /* current at the end of the last window [A] */
    ab_t before;              /* Psi_m at the beginning, once psi_f is known [Wb] */
    float xx, xy, yy, xz, yz; /* sums for the fit of the circle */
    float impulse;            /* int of the torque [N m s] */
    float moving;             /* time of motion forwards minus that backwards [s] */
    float peak;               /* largest speed, electrical [rad/s] */
    uint32_t over; /* [-] 1: the first motion after the jump has ended, and friction holds the rotor */
} swing_motion_t;

/* Sums of the regression of the impulse against speed and duration of the motion. */
typedef struct {
    float ww, wt, tt, wp, tp, pp;
} swing_fit_t;

typedef enum { SWING_BEGIN, SWING_ALIGN, SWING_JUMP, SWING_REST } swing_phase_t;

typedef struct {
    int32_t phase;    /* [-] swing_phase_t */
    uint32_t jump;    /* [-] */
    uint32_t windows; /* [windows] of this jump */
    uint32_t again;   /* [-] number of times that the current was reduced for a salient rotor */
    uint32_t freer;   /* [-] number of times that the braking was reduced, because J could not be measured */
    float flux, inertia, share; /* of the jumps with the best measurement of J [Wb], [kg m^2], [-] */
    float current;              /* [A] */
    ab_t rest[2];   /* voltage at rest in addition to that of the equation, for each direction [V] */
    float flux_sum; /* of psi_f over the jumps [Wb] */
    float flux_least, flux_most; /* of the same [Wb] */
    swing_motion_t motion;
    swing_fit_t fit;
    standing_t standing;
} swing_step_t;

void swing_step_begin(swing_step_t *step);

commission_verdict_t swing_step(swing_step_t *step, const commission_tuning_t *tuning,
                                const commission_input_t *input, excite_order_t *order,
                                commission_results_t *results);

#endif
