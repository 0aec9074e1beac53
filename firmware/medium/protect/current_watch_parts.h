/* What the files of current_watch.h share; nobody else. */
#ifndef MEDIUM_PROTECT_CURRENT_WATCH_PARTS_H
#define MEDIUM_PROTECT_CURRENT_WATCH_PARTS_H

#include "medium/protect/current_watch.h"

/* What a window says, before it is judged. */
typedef struct {
    float periods;   /* [-] of it */
    ab_t current;    /* at its end [A] */
    float value[3];  /* likewise, phase by phase, what follows too [A] */
    float change[3]; /* m [A] */
    float error[3];  /* by which the observer misses it at its end [A] */
    float given[3];  /* p without the EMF [A] */
    float moved[3];  /* p [A] */
    float dead;      /* what dead time and drops may take [A] */
    float resistive; /* what of R i may be wrong [A] */
    float emf;       /* what of the EMF may be wrong [A] */
    float reverse;   /* likewise if the rotor is anywhere [A] */
    float largest;   /* amount of the phase currents [A] */
} current_watch_window_t;

/* One after the other. */
static inline void spread(float out[3], abc_t phases)
{
    out[0] = phases.a;
    out[1] = phases.b;
    out[2] = phases.c;
}

/* What is new in a window, m against p: of both sensors together, and of a beside b. Where the EMF does not
 * go on smoothly (`comparable`) nothing is, and the sums begin anew. true: their gain is out of what wrong
 * beliefs explain. */
bool current_watch_gain(current_watch_t *watch, const current_watch_input_t *input,
                        const current_watch_window_t *window);

/* Is a phase beside this one fed, and no current flows? Past an open wire the current of the others may
 * stand, whatever the voltage; and in 4 periods its noise repeats itself. */
bool current_watch_feeds_another(const current_watch_t *watch, uint32_t n);

/* Phases without the current that they are asked for: CURRENT_WATCH_LOSS and _MAYBE. */
uint32_t current_watch_wires(current_watch_t *watch, const current_watch_input_t *input,
                             const current_watch_window_t *window);

#endif
