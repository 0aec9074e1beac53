/* The capture: selected slots of a struct, copied unchanged once per period into one ring buffer, and held
 * after a trigger. It gives the time before an event with names and values, independent of the speed of the
 * serial link that reads them.
 *
 * Every period is one row of the ring, in whole fours of slots, so that the copy is short. With few columns
 * the ring is long: up to CAPTURE_PERIODS for up to eight columns. States:
 *
 *     idle        no client has armed the capture: the rows of the start's tuning are kept until a fault
 *     armed       the rows of the client are kept, and the capture waits for the trigger
 *     triggered   the periods after the trigger are kept
 *     held        no more rows are kept, so the ring can be read without a change
 *
 * A fault always triggers, unless the ring is already held or waits for its last periods. */
#ifndef CONTRACT_CAPTURE_H
#define CONTRACT_CAPTURE_H

#include <stdint.h>

#include "contract/table.h"

#define CAPTURE_SLOTS   UINT32_C(4096) /* of the ring, 32 bits each */
#define CAPTURE_COLUMNS UINT32_C(12)   /* at most */
#define CAPTURE_PERIODS UINT32_C(512)  /* at most */

typedef enum { CAPTURE_IDLE, CAPTURE_ARMED, CAPTURE_TRIGGERED, CAPTURE_HELD } capture_state_t;
#define CAPTURE_STATE_NAMES "idle|armed|triggered|held"

/* Triggers beside a fault. An edge: the value was not beyond the level in the previous period, and is now;
 * the first period after arming counts as the previous one. */
typedef enum { CAPTURE_ON_FAULT, CAPTURE_ON_ABOVE, CAPTURE_ON_BELOW, CAPTURE_ON_COMMAND } capture_on_t;
#define CAPTURE_ON_NAMES "fault|above|below|command"

/* Requested capture, by ids of the table. */
typedef struct {
    int32_t on;                   /* [-] CAPTURE_ON_... */
    uint32_t source;              /* [-] id of the row whose value triggers, for an edge */
    float level;                  /* [unit of the source] */
    uint32_t after;               /* [periods] kept after that of the trigger */
    uint32_t columns;             /* [-] 1..CAPTURE_COLUMNS */
    uint32_t id[CAPTURE_COLUMNS]; /* [-] ids of the columns' rows; those beyond `columns` are ignored */
} capture_wish_t;

/* The first error in a request. */
typedef enum {
    CAPTURE_GOOD,
    CAPTURE_BAD_ON,      /* no such trigger */
    CAPTURE_BAD_SOURCE,  /* no row has this id, and the trigger is an edge of that row */
    CAPTURE_BAD_LEVEL,   /* the level is not a number, and the trigger is an edge of a row */
    CAPTURE_BAD_AFTER,   /* the period of the trigger would have left the ring */
    CAPTURE_BAD_COLUMNS, /* zero, or too many */
    CAPTURE_BAD_ID       /* no row has the id of the first column; one more for each next column */
} capture_refusal_t;

typedef struct {
    uint32_t on;                     /* [-] CAPTURE_ON_... */
    uint32_t kind;                   /* [-] slot_kind_t of the source */
    uint32_t source;                 /* [chars of the target] place of its slot */
    float level;                     /* [unit of the source] */
    uint32_t after;                  /* [periods] kept after that of the trigger */
    uint32_t columns;                /* [-] of a row; the slots after them in the last four are undefined */
    uint32_t width;                  /* [slots] of a row: whole fours */
    uint32_t periods;                /* [-] rows of the ring */
    uint32_t ring;                   /* [slots] of all its rows */
    uint32_t id[CAPTURE_COLUMNS];    /* [-] of each column */
    uint32_t place[CAPTURE_COLUMNS]; /* [chars of the target] of its slot */
} capture_tuning_t;

typedef struct {
    uint32_t state;  /* [-] capture_state_t */
    uint32_t asked;  /* [-] 1: armed by a client */
    uint32_t next;   /* [slots] where the next row begins */
    uint32_t full;   /* [-] 1: each row of the ring is in use */
    uint32_t newest; /* [periods] that of the newest row; the others precede it without a gap */
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

/* Number of periods with this number of columns that fit into the ring buffer, at most CAPTURE_PERIODS. */
static inline uint32_t capture_room(uint32_t columns)
{
    const uint32_t room = CAPTURE_SLOTS / capture_width(columns);
    return room < CAPTURE_PERIODS ? room : CAPTURE_PERIODS;
}

/* Converts a request to places and kinds of this table, for a struct that the table describes. For any result
 * except CAPTURE_GOOD, which is 0, `tuning` is unchanged; CAPTURE_BAD_ID + n: the id of column n, from 0, is
 * wrong. */
uint32_t capture_prepare(const capture_wish_t *wish, const table_t *table, capture_tuning_t *tuning);

/* Idle and empty, with this tuning: rows are kept until a fault. capture_release: the same for a ring in
 * use. */
void capture_init(capture_t *capture, const capture_tuning_t *tuning);
void capture_release(capture_t *capture, const capture_tuning_t *tuning);

/* Armed and empty, with this tuning. */
void capture_arm(capture_t *capture, const capture_tuning_t *tuning);

/* The trigger has come with this period, before or after its row is stored. No effect while triggered or
 * held. */
void capture_trigger(capture_t *capture, uint32_t period);

/* A fault was reset: a ring that no client has armed is cleared. */
void capture_reset(capture_t *capture);

/* One period, in the interrupt: stores its row of `base` and evaluates its trigger. One pass over the
 * columns. */
void capture_step(capture_t *capture, const void *base, uint32_t period);

/* [periods] kept, up to tuning.periods. */
uint32_t capture_count(const capture_t *capture);

/* The row that is `n` periods younger than the oldest; `n` is below the count. */
const uint32_t *capture_row(const capture_t *capture, uint32_t n);

#endif
