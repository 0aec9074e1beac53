/* The capture: chosen slots of a struct, copied once per period as they stand into one ring, and held after a
 * trigger: the moment before an event in numbers with names, however slow the line is that reads them.
 *
 * Every period is one row of the ring, in whole fours of slots, so that the copy is short; few columns reach
 * far back: up to eight of them CAPTURE_PERIODS.
 * States:
 *
 *   idle        the rows that nobody asked for are kept, up to the next fault: those of the start's tuning
 *   armed       the rows that were asked for are kept, and the trigger is waited for
 *   triggered   so many periods more are kept
 *   held        nothing is kept any more, so the ring can be read in peace
 *
 * A fault triggers always, unless the ring is already held or waits for its last periods. */
#ifndef CONTRACT_CAPTURE_H
#define CONTRACT_CAPTURE_H

#include <stdint.h>

#include "contract/table.h"

#define CAPTURE_SLOTS   UINT32_C(4096) /* of the ring, 32 bits each */
#define CAPTURE_COLUMNS UINT32_C(12)   /* at most */
#define CAPTURE_PERIODS UINT32_C(512)  /* at most */

typedef enum { CAPTURE_IDLE, CAPTURE_ARMED, CAPTURE_TRIGGERED, CAPTURE_HELD } capture_state_t;
#define CAPTURE_STATE_NAMES "idle|armed|triggered|held"

/* Besides a fault. An edge: the value was not beyond the level in the period before, and is now; the first
 * period after arming counts as the one before. */
typedef enum { CAPTURE_ON_FAULT, CAPTURE_ON_ABOVE, CAPTURE_ON_BELOW, CAPTURE_ON_COMMAND } capture_on_t;
#define CAPTURE_ON_NAMES "fault|above|below|command"

/* What is wished for, by ids of the table. */
typedef struct {
    int32_t on;                   /* [-] CAPTURE_ON_... */
    uint32_t source;              /* [-] id of the row whose value triggers, where an edge does */
    float level;                  /* [unit of the source] */
    uint32_t after;               /* [periods] kept after the trigger's own */
    uint32_t columns;             /* [-] 1..CAPTURE_COLUMNS */
    uint32_t id[CAPTURE_COLUMNS]; /* [-] ids of the columns' rows; those beyond `columns` do not matter */
} capture_wish_t;

/* The first thing in a wish that cannot be done. */
typedef enum {
    CAPTURE_GOOD,
    CAPTURE_BAD_ON,      /* no such trigger */
    CAPTURE_BAD_SOURCE,  /* no row has this id, and an edge of it shall trigger */
    CAPTURE_BAD_LEVEL,   /* the level is not a number, and an edge of a row shall trigger */
    CAPTURE_BAD_AFTER,   /* the trigger's own period would have left the ring */
    CAPTURE_BAD_COLUMNS, /* none, or too many */
    CAPTURE_BAD_ID       /* no row has the id of the first column; of the second: one more, and so on */
} capture_refusal_t;

typedef struct {
    uint32_t on;                     /* [-] CAPTURE_ON_... */
    uint32_t kind;                   /* [-] slot_kind_t of the source */
    uint32_t source;                 /* [chars of the target] place of its slot */
    float level;                     /* [unit of the source] */
    uint32_t after;                  /* [periods] kept after the trigger's own */
    uint32_t columns;                /* [-] of a row; what is behind them in its last four means nothing */
    uint32_t width;                  /* [slots] of a row: whole fours */
    uint32_t periods;                /* [-] rows of the ring */
    uint32_t ring;                   /* [slots] of all its rows */
    uint32_t id[CAPTURE_COLUMNS];    /* [-] of each column */
    uint32_t place[CAPTURE_COLUMNS]; /* [chars of the target] of its slot */
} capture_tuning_t;

typedef struct {
    uint32_t state;  /* [-] capture_state_t */
    uint32_t asked;  /* [-] 1: armed from outside */
    uint32_t next;   /* [slots] where the next row begins */
    uint32_t full;   /* [-] 1: each row of the ring is in use */
    uint32_t newest; /* [periods] that of the newest row; the others are its forerunners without a gap */
    uint32_t at;     /* [periods] that of the last trigger */
    uint32_t beyond; /* [-] 1: the source was beyond its level in the last period */
    capture_tuning_t tuning;
    uint32_t slots[CAPTURE_SLOTS];
} capture_t;

/* [slots] of a row, for 1..CAPTURE_COLUMNS columns. */
static inline uint32_t capture_width(uint32_t columns)
{
    return (columns + 3u) & ~UINT32_C(3);
}

/* How many periods of so many columns fit into the ring: CAPTURE_PERIODS at most. */
static inline uint32_t capture_room(uint32_t columns)
{
    const uint32_t room = CAPTURE_SLOTS / capture_width(columns);
    return room < CAPTURE_PERIODS ? room : CAPTURE_PERIODS;
}

/* A wish as places and kinds of this table, for a struct that the table describes. Anything but CAPTURE_GOOD,
 * which is 0: `tuning` is as it was; CAPTURE_BAD_ID + n: the id of column n, from 0, is the wrong one. */
uint32_t capture_prepare(const capture_wish_t *wish, const table_t *table, capture_tuning_t *tuning);

/* Idle and empty, with this tuning: kept until a fault. capture_release: the same, of a ring in use. */
void capture_init(capture_t *capture, const capture_tuning_t *tuning);
void capture_release(capture_t *capture, const capture_tuning_t *tuning);

/* Armed and empty, with this tuning. */
void capture_arm(capture_t *capture, const capture_tuning_t *tuning);

/* The trigger has come with this period, whether its row is kept already or comes now. Nothing while
 * triggered or held. */
void capture_trigger(capture_t *capture, uint32_t period);

/* A fault was reset: a ring that nobody has asked for begins anew. */
void capture_reset(capture_t *capture);

/* One period, in the interrupt: its row of `base`, and its trigger. One pass over the columns. */
void capture_step(capture_t *capture, const void *base, uint32_t period);

/* [periods] kept, up to tuning.periods. */
uint32_t capture_count(const capture_t *capture);

/* The row that is so many periods younger than the oldest; `n` below the count. */
const uint32_t *capture_row(const capture_t *capture, uint32_t n);

#endif
