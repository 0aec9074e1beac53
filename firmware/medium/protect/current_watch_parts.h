/* Declarations shared by the files of current_watch.h alone. */
#ifndef MEDIUM_PROTECT_CURRENT_WATCH_PARTS_H
#define MEDIUM_PROTECT_CURRENT_WATCH_PARTS_H

#include "medium/protect/current_watch.h"

/* The values of a window before the judgement. */
typedef struct {
    float periods;   /* [-] in the window */
    ab_t current;    /* at its end [A] */
    float value[3];  /* the same by phase, as are the following [A] */
    float change[3]; /* m [A] */
    float error[3];  /* error of the observer at its end [A] */
    float given[3];  /* p without the EMF [A] */
    float moved[3];  /* p [A] */
    float dead;      /* largest effect of dead time and drops [A] */
    float resistive; /* uncertain part of R i [A] */
    float emf;       /* uncertain part of the EMF [A] */
    float any;       /* EMF of a rotor with any flux from none on [A] */
    float reverse;   /* the same for any position of the rotor [A] */
    float largest;   /* largest magnitude of the phase currents [A] */
} current_watch_window_t;

/* Stores the phases in an array. */
static inline void spread(float out[3], abc_t phases)
{
    out[0] = phases.a;
    out[1] = phases.b;
    out[2] = phases.c;
}

/* Compares the new part of the change in a window, m with p: of both sensors together, and of a with b. Where
 * the EMF does not change smoothly (`comparable`) nothing is compared, and the sums restart. true: the gain
 * is outside the range that wrong assumed values explain. */
bool current_watch_gain(current_watch_t *watch, const current_watch_input_t *input,
                        const current_watch_window_t *window);

/* True if another phase gets a voltage and carries no current. With an open wire the current of the others
 * may be constant for any voltage, and in 4 periods its noise repeats itself. */
bool current_watch_feeds_another(const current_watch_t *watch, uint32_t n);

/* Phases without the requested current: CURRENT_WATCH_LOSS and _MAYBE. */
uint32_t current_watch_wires(current_watch_t *watch, const current_watch_input_t *input,
                             const current_watch_window_t *window);

#endif
