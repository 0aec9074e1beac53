/* Measures psi_f, J and friction of a motor that the drive runs without encoder.
 *
 *     psi_f      means at a steady speed, with a current on the d axis that keeps the signs of the legs
 *                certain:   psi_f = |e|/omega - (L_d - L_q) i_d       e: back-EMF of the active flux
 *     friction   the torque of two steady speeds, less J times the remaining acceleration
 *     J          torque up, coast, brake, two times or more; over slices of N windows
 *                  a = (1.5 p psi i_q - T_c - B omega)/J              least squares
 *                the two steady speeds are rows of this fit, too: the phases of a light rotor have nearly
 *                the same mean speed, from which B could not be separated
 *                speed and acceleration of a slice from a parabola through the angles of its EMF; a is the
 *                dependent one, because it is far noisier than the torque, and noise of an independent one
 *                would make its coefficient too small
 *
 * These steps order a speed or a current; start, hand-over and run are those of the drive. */
#ifndef MEDIUM_COMMISSION_TURNING_STEPS_H
#define MEDIUM_COMMISSION_TURNING_STEPS_H

#include "medium/commission/commission_types.h"
#include "medium/commission/turning_fit.h"
#include "medium/commission/turning_window.h"

/* The order to the drive. */
typedef struct {
    uint32_t by_current; /* [-] 1: i_q of `current`; 0: the speed */
    float omega_m_ref;   /* [rad/s] mechanical */
    dq_t current;        /* [A]; its d axis in both cases */
} turning_wish_t;

/* Sums over a steady speed. */
typedef struct {
    float windows; /* [windows] */
    float omega;   /* electrical [rad/s] */
    float speed;   /* magnitude of the same [rad/s] */
    float volts;   /* EMF of the magnets minus that of an approximate psi_f [V] */
    float square;  /* its square [V^2] */
    float torque;  /* [N m] */
} turning_mean_t;

/* Detection of a steady speed. */
typedef struct {
    uint32_t windows; /* [windows] at the speed */
    float omega_e;    /* low-passed estimate [rad/s] */
} turning_steady_t;

typedef struct {
    turning_steady_t steady;
    turning_mean_t mean;
} flux_test_t;

/* A slice of the torque test. */
typedef struct {
    uint32_t windows; /* [windows] so far */
    uint32_t skipped; /* [windows] after a change of the torque */
    float angle;      /* electrical angle of the EMF at the last window [rad] */
    float turned;     /* since the first window of the slice [rad] */
    float linear;     /* sum of the angle times m [rad]; m: window from the middle of the slice */
    float square;     /* the same times m^2 - (N^2 - 1)/12, the orthogonal polynomial of second degree */
    float torque;     /* sum [N m] */
} turning_slice_t;

typedef enum { TORQUE_STEADY_FAST, TORQUE_STEADY_SLOW, TORQUE_UP, TORQUE_COAST, TORQUE_DOWN } torque_phase_t;

/* A steady speed. */
typedef struct {
    float torque;       /* mean [N m] */
    float omega;        /* mean, mechanical [rad/s] */
    float acceleration; /* remaining one, mechanical [rad/s^2] */
} turning_point_t;

typedef struct {
    int32_t phase;    /* [-] torque_phase_t */
    uint32_t cycle;   /* [-] */
    uint32_t windows; /* [windows] of this phase */
    turning_steady_t steady;
    float push;         /* i_q upwards [A] */
    float earlier;      /* J of a first test that disagreed with the swing; 0: none [kg m^2] */
    uint32_t length[3]; /* N: of a slice up, coasting, down [windows] */
    uint32_t coasts;    /* largest length of the coast [windows] */
    float low, high;    /* speeds, mechanical [rad/s] */
    turning_slice_t slice;
    turning_fit_t fit;
    turning_mean_t mean;
    float half;               /* sum of omega_e over the first half of a steady speed [rad/s] */
    uint32_t changed;         /* [-] 1: the friction is no longer that of the steady speeds */
    turning_point_t point[2]; /* fast, slow */
} torque_test_t;

void flux_test_begin(flux_test_t *step);
commission_verdict_t flux_test_step(flux_test_t *step, const commission_tuning_t *tuning,
                                    const turning_input_t *seen, turning_wish_t *wish,
                                    commission_results_t *results);

void torque_test_begin(torque_test_t *step);
commission_verdict_t torque_test_step(torque_test_t *step, const commission_tuning_t *tuning,
                                      const turning_input_t *seen, turning_wish_t *wish,
                                      commission_results_t *results);

#endif
