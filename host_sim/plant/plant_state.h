/* State of the plant; included by plant.h only. Only plant_set_params writes the coefficients, which are the
 * first fields. */
#ifndef HOST_SIM_PLANT_PLANT_STATE_H
#define HOST_SIM_PLANT_PLANT_STATE_H

#include <stdint.h>

#include "host_sim/plant/plant_params.h"

#define PLANT_PENDING 32 /* capacity: six gates with four edges each, rounded up to a power of two */

/* Pole voltage of a leg outside the zone: v = s V_dc + d - r i. Index 0: i > 0, index 1: i < 0. The current
 * from the link is s i. */
typedef struct {
    double s[2]; /* [-] share of the time for which the leg is connected to the positive link terminal (0 or 1
                    between edges) */
    double d[2]; /* [V] drop at no current, as it adds to the pole voltage */
    double r[2]; /* [ohm] slope of the drop */
} plant_law_t;

/* Index into the laws of a leg; the first four are the two gate bits of a leg. */
enum { PLANT_LAW_OFF, PLANT_LAW_UPPER, PLANT_LAW_LOWER, PLANT_LAW_BOTH, PLANT_LAW_AVERAGED };

/* Switches whose zero vector is at the ends of a carrier period. */
enum { PLANT_EDGES, PLANT_AVERAGED_LOWER, PLANT_AVERAGED_UPPER };

/* A commanded edge that has not acted yet. */
typedef struct {
    uint64_t tick; /* [tick] when it acts */
    uint32_t gate; /* [-] bit number 0..5 */
    uint32_t on;   /* [-] 1: turns on */
} plant_edge_t;

typedef struct {
    plant_params_t params;
    double p;               /* pole pairs [-] */
    double count_per_rad;   /* [counts/rad] of the encoder, per electrical radian */
    double r_mean;          /* [ohm] mean slope of the drops, treated as part of R between edges */
    double decay_d;         /* (R + r_mean)/L_d [1/s] */
    double decay_q;         /* (R + r_mean)/L_q [1/s] */
    double k_d, k_q;        /* 1/L_d, 1/L_q [1/H] */
    double k_max;           /* the larger of the two [1/H] */
    double cross_d;         /* L_q/L_d [-] */
    double cross_q;         /* L_d/L_q [-] */
    double saliency;        /* L_d - L_q [H] */
    double emf_q;           /* psi_f/L_q [A] */
    double emf_d6;          /* psi_f (k_5 + k_7) [Wb] */
    double emf_q6;          /* psi_f (k_7 - k_5) [Wb] */
    double rate;            /* [1/s] of the electrical decay and of the oscillation of currents and shaft */
    double emf_bound;       /* psi_f (1 + |k_5| + |k_7|) [Wb] */
    double inertia_inverse; /* 1/J [1/(kg m^2)] */
    double dry_torque;      /* T_c + T_passive + T_brake [N m] */
    double
        hold_torque; /* T_h [N m] torque that dry friction holds at standstill; 0: the friction is smooth */
    double active_torque;      /* [N m] */
    double width_inverse;      /* 1/w [s/rad] */
    double zone;               /* [A] half width of the zone */
    double zone_inverse;       /* [1/A] */
    double trip_square;        /* [A^2]; 1e300: no protection */
    double volts_per_ampere;   /* [V/A] of the current sensors */
    double volts_per_volt;     /* [-] of the DC-link sensor */
    double source_rate;        /* 1/(R_dc C) [1/s]; 0: stiff link */
    double link_rate;          /* 1/C [1/F]; 0: stiff link */
    double supplied;           /* [A s] from the source into a soft link, since init */
    double chopper_rate;       /* 1/(R_chopper C) [1/s]; 0: none */
    double load_torque;        /* T_passive at the load end of an elastic shaft [N m], else 0 */
    double load_active;        /* T_active at the load end of an elastic shaft [N m], else 0 */
    double load_inverse;       /* 1/J_load [1/(kg m^2)]; 0: the shaft is rigid */
    double load_width_inverse; /* 1/w of the load end [s/rad] */
    double work_rate;          /* [1/s] of the oscillation of the inertia with spring and sine load, if any */
    double table[8];           /* [N m] load at 0 .. 7 times load_table_speed; the last two are equal */
    double table_inverse;      /* [s/rad] of load_table_speed; 0: no table */
    double bend_d, bend_q;     /* 1/I_s^2 of either axis [1/A^2]; 0: linear */
    double ohms;               /* [ohm] the resistance in `rate` */
    double rate_other;         /* [1/s] the part of `rate` that does not depend on an inductance */
    double saturates; /* [-] 1: an axis saturates, or the iron has losses; k_max and rate are those of the
                         present currents */
    plant_law_t law[3][PLANT_LAW_AVERAGED + 1];

    double i[3];                  /* [A] phase currents */
    double i_d, i_q;              /* [A] the same in the rotor frame */
    double theta_e;               /* [rad] in [-pi, pi) */
    double cos_e, sin_e;          /* [-] of theta_e */
    double omega_m;               /* [rad/s] */
    double omega_ahead;           /* [rad/s] extrapolated to the present tick */
    double acceleration;          /* [rad/s^2] mean over the last interval */
    double twist;                 /* [rad] of an elastic shaft, the motor ahead */
    double omega_load;            /* [rad/s] of its load end */
    double shaft_torque;          /* [N m] from the motor into it */
    double slip;                  /* [-] sign of the motion, +-1, where T_h > 0; 0: the shaft is held */
    double brake_torque;          /* [N m] of the brake on the shaft */
    double torque;                /* [N m] */
    double v_dc;                  /* [V] */
    double flux_alpha, flux_beta; /* [V s] */
    double sensed[3];             /* [A] phase currents after the lag of the sensors */
    double energy_dc;             /* [J] */
    double energy_copper;         /* [J] */
    double energy_inverter;       /* [J] */
    double energy_mechanical;     /* [J] */

    uint64_t tick;
    uint64_t turn_on_ticks[3]; /* of a leg's upper and lower command */
    uint64_t turn_off_ticks;
    uint64_t pulse_ticks;
    uint64_t fault_until;        /* [tick] end of the active fault output */
    uint64_t calm_ticks;         /* [ticks] time for which all legs have been off and inside the zone */
    uint64_t shoot_through_tick; /* [tick] PLANT_NEVER: none yet */
    uint64_t random;             /* state of the noise */
    uint64_t period_end;         /* [tick] end of the carrier period of the averaged laws */
    uint64_t holding_since;      /* [tick] of the last change of the brake output */
    uint64_t ripple_since;       /* [tick] at which the ripple of the source has the phase 0 */
    uint64_t works;              /* a load depends on the square of the speed, on the table or on the angle */
    int64_t count_shift;         /* [counts] difference of the encoder from the present state of its tracks */
    int64_t count_whole;         /* [counts] of the whole mechanical turns in `turns` */
    double count_rest;           /* [counts] of the remaining electrical turns, and of the encoder's offset */
    int64_t turns;               /* [-] electrical revolutions, theta = theta_e + 2 pi turns */
    plant_edge_t pending[PLANT_PENDING];
    uint32_t pending_first; /* [-] ring index of the edge that acts next */
    uint32_t pending_count;
    uint32_t waiting[6];  /* [-] edges of each gate among them */
    uint32_t kind[3];     /* index into law */
    uint32_t commanded;   /* gate bits at the module's inputs */
    uint32_t on;          /* gate bits after the delays */
    uint32_t shut;        /* gate bits shut by the module */
    uint32_t open;        /* bit n: phase n is broken */
    uint32_t never_on;    /* gate bits of IGBTs that never conduct */
    uint32_t always_on;   /* gate bits of IGBTs that always conduct */
    uint32_t stuck_gates; /* those of both */
    uint32_t wire[3];  /* phase that is connected to leg n; all other fields, including gates and laws, are by
                          phases */
    uint32_t rewired;  /* two of these wires are exchanged */
    uint32_t tracks;   /* the tracks of the encoder do not follow its disc */
    uint32_t ripples;  /* the link has no capacitor, and its voltage is not constant */
    uint32_t uneven;   /* a leg has an additional resistance */
    uint32_t averaged; /* PLANT_EDGES: no; else the switches that are on at the ends of a period */
    uint32_t map;      /* [-] number of the flux map; 0: none */
    uint32_t chops;    /* the chopper output is on */
    uint32_t released; /* the brake output is on */
    uint32_t holds;    /* the holding brake is set */
    uint32_t idle;     /* no current flows: only the shaft moves */
    uint32_t harmonics; /* the EMF has harmonics */
    uint32_t metering;
    uint32_t extras; /* metering, a variable link or sensor lag: sums are needed */
    uint32_t steps;  /* steps since the phasor was computed from the angle */
    uint32_t shoot_throughs;
    uint32_t shoot_through_leg;
    uint32_t period;  /* [tick] of the carrier, averaged mode */
    uint32_t high[3]; /* [tick] of the carrier in which the upper switches are commanded on, averaged mode */
    uint32_t dead;    /* [tick] dead band, averaged mode */
} plant_t;

#endif
