/* The capture: in each period it copies selected slots of a struct into a ring buffer. After a trigger the
 * buffer keeps its content. A client then reads the time before an event with names and values, independent
 * of the speed of the serial link.
 *
 * Each period is one row of the ring. The number of slots of a row is a multiple of four, which makes the
 * copy short. With few columns the ring is long: up to CAPTURE_PERIODS for up to eight columns. States:
 *
 *     idle        no client has armed the capture: the default columns are stored until a fault
 *     armed       the columns of the client are stored, and the capture waits for the trigger
 *     triggered   the periods after the trigger are stored
 *     held        nothing more is stored, so that the ring can be read without a change
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

/* Triggers. ABOVE and BELOW are edges: the value passes the level from one period to the next. The first
 * period after arming cannot trigger. A fault always triggers. */
typedef enum { CAPTURE_ON_FAULT, CAPTURE_ON_ABOVE, CAPTURE_ON_BELOW, CAPTURE_ON_COMMAND } capture_on_t;
#define CAPTURE_ON_NAMES "fault|above|below|command"

/* Requested capture, by ids of the table. */
typedef struct {
    int32_t on;                   /* [-] CAPTURE_ON_... */
    uint32_t source;              /* [-] id of the row whose value triggers, for an edge */
    float level;                  /* [unit of the source] */
    uint32_t after;               /* [periods] stored after the period of the trigger */
    uint32_t columns;             /* [-] 1..CAPTURE_COLUMNS */
    uint32_t id[CAPTURE_COLUMNS]; /* [-] ids of the table's rows for the first `columns` columns */
} capture_wish_t;

/* The first error in a request. */
typedef enum {
    CAPTURE_GOOD,
    CAPTURE_BAD_ON,      /* no such trigger */
    CAPTURE_BAD_SOURCE,  /* no row has this id, and the trigger is an edge of that row */
    CAPTURE_BAD_LEVEL,   /* the level is not a number, and the trigger is an edge of a row */
    CAPTURE_BAD_AFTER,   /* the ring has fewer rows than these periods */
    CAPTURE_BAD_COLUMNS, /* zero, or too many */
    CAPTURE_BAD_ID       /* no row has the id of the first column; + n: the same of column n */
} capture_refusal_t;

typedef struct {
    uint32_t on;      /* [-] CAPTURE_ON_... */
    uint32_t kind;    /* [-] slot_kind_t of the source */
    uint32_t source;  /* [chars of the target] offset of the slot of the source */
    float level;      /* [unit of the source] */
    uint32_t after;   /* [periods] stored after the period of the trigger */
    uint32_t columns; /* [-] columns of a row; the other slots of its last group of four are undefined */
    uint32_t width;   /* [slots] of a row, a multiple of four */
    uint32_t periods; /* [-] rows of the ring */
    uint32_t ring;    /* [slots] of all its rows */
    uint32_t id[CAPTURE_COLUMNS];    /* [-] of each column */
    uint32_t place[CAPTURE_COLUMNS]; /* [chars of the target] offset of the slot of each column */
} capture_tuning_t;

typedef struct {
    uint32_t state;  /* [-] capture_state_t */
    uint32_t asked;  /* [-] 1: armed by a client */
    uint32_t next;   /* [slots] where the next row begins */
    uint32_t full;   /* [-] 1: each row of the ring is in use */
    uint32_t newest; /* [periods] that of the newest row; the rows before it have no gap */
    uint32_t at;     /* [periods] number of the period of the last trigger */
    uint32_t beyond; /* [-] 1: the source had passed its level in the last period */
    capture_tuning_t tuning;
    uint32_t slots[CAPTURE_SLOTS];
} capture_t;

/* [slots] of a row, for 1..CAPTURE_COLUMNS columns. */
static inline uint32_t capture_width(uint32_t columns)
{
    return (columns + 3u) & ~UINT32_C(3);
}

/* Number of periods with this number of columns that fit into the ring, at most CAPTURE_PERIODS. */
static inline uint32_t capture_room(uint32_t columns)
{
    const uint32_t room = CAPTURE_SLOTS / capture_width(columns);
    return room < CAPTURE_PERIODS ? room : CAPTURE_PERIODS;
}

/* Converts the ids of a request to offsets and kinds, by the table of the struct. Returns CAPTURE_GOOD (0),
 * or an error and leaves `tuning` unchanged. CAPTURE_BAD_ID + n: the id of column n, counted from 0, is
 * wrong. */
uint32_t capture_prepare(const capture_wish_t *wish, const table_t *table, capture_tuning_t *tuning);

/* Sets the state idle with an empty ring and this tuning. capture_release: the same for a ring in use. */
void capture_init(capture_t *capture, const capture_tuning_t *tuning);
void capture_release(capture_t *capture, const capture_tuning_t *tuning);

/* Sets the state armed with an empty ring and this tuning. */
void capture_arm(capture_t *capture, const capture_tuning_t *tuning);

/* Triggers at this period, before or after its row is stored. No effect in the states triggered and held. */
void capture_trigger(capture_t *capture, uint32_t period);

/* Call it after the reset of a fault: clears the ring unless a client has armed it. */
void capture_reset(capture_t *capture);

/* One period, in the interrupt: stores its row of `base` and evaluates its trigger. One pass over the
 * columns. */
void capture_step(capture_t *capture, const void *base, uint32_t period);

/* [periods] stored, up to tuning.periods. */
uint32_t capture_count(const capture_t *capture);

/* The row that is `n` periods newer than the oldest one; `n` is below the count. */
const uint32_t *capture_row(const capture_t *capture, uint32_t n);

#endif
