/* The master's inside: the engine (master.c), and what is asked with it (master_calls.c, master_daq.c). */
#ifndef HOST_SIM_LINE_MASTER_PARTS_H
#define HOST_SIM_LINE_MASTER_PARTS_H

#include "host_sim/line/frames.h"
#include "host_sim/line/master.h"
#include "host_sim/line/transport.h"

/* Commands and marks of XCP 1.x. */
enum {
    XCP_RESPONSE = 0xFF,
    XCP_ERROR = 0xFE,
    XCP_EVENT = 0xFD,
    XCP_SERVICE = 0xFC,

    XCP_CONNECT = 0xFF,
    XCP_DISCONNECT = 0xFE,
    XCP_SYNCH = 0xFC,
    XCP_GET_SEED = 0xF8,
    XCP_UNLOCK = 0xF7,
    XCP_SET_MTA = 0xF6,
    XCP_SHORT_UPLOAD = 0xF4,
    XCP_DOWNLOAD = 0xF0,
    XCP_GET_CAL_PAGE = 0xEA,
    XCP_SET_DAQ_PTR = 0xE2,
    XCP_WRITE_DAQ = 0xE1,
    XCP_SET_DAQ_LIST_MODE = 0xE0,
    XCP_START_STOP_DAQ_LIST = 0xDE,
    XCP_START_STOP_SYNCH = 0xDD,
    XCP_GET_DAQ_CLOCK = 0xDC,
    XCP_GET_DAQ_RESOLUTION_INFO = 0xD9,
    XCP_FREE_DAQ = 0xD6,
    XCP_ALLOC_DAQ = 0xD5,
    XCP_ALLOC_ODT = 0xD4,
    XCP_ALLOC_ODT_ENTRY = 0xD3,

    XCP_ERROR_SYNCH = 0x00,
    XCP_EVENT_DAQ_OVERLOAD = 0x06,
    XCP_EVENT_PENDING = 0x05,
};

/* One or two packets that belong together: a write is SET_MTA and DOWNLOAD, and is repeated as a whole. */
#define QUESTION_PACKETS 2u
typedef struct {
    uint8_t packets[QUESTION_PACKETS][8];
    uint8_t lengths[QUESTION_PACKETS];
    uint32_t count;   /* [-] packets */
    uint32_t octets;  /* [octets] that the last answer has; MASTER_ANY: not judged */
    double patience;  /* [s] */
    uint32_t repeats; /* [-] so far */
    uint32_t busy;    /* [-] answers so far that the drive is busy */
    master_answer_t answer;
    void *context;
} question_t;
#define MASTER_ANY UINT32_MAX

typedef enum { LINE_IDLE, LINE_ASKED, LINE_BUSY, LINE_SYNCHING } line_state_t;

typedef struct {
    bool running;
    uint32_t first_pid; /* [-] */
    uint32_t count;     /* [-] rows */
    uint32_t every;     /* [periods] */
    uint32_t lists;     /* [-] packets of a sample */
    uint32_t next;      /* [-] packet that is due */
    uint32_t period;    /* [periods] of the sample under way */
    uint32_t last;      /* [periods] of the last one; valid from the second on */
    uint32_t taken;     /* [-] slots of it */
    uint32_t slots[MASTER_DAQ_MAX];
    uint32_t frames_missing, octets_dropped; /* at the start of the samples */
    master_daq_t sum;
    master_sink_t sink;
    void *context;
} daq_t;

struct master {
    int descriptor;
    bool can_open; /* `name` is a target */
    char name[TRANSPORT_NAME_SIZE];
    char epk[24];
    char lost[256];
    frames_t in;
    uint8_t out[2048];
    uint32_t out_begin, out_end;
    uint16_t counter; /* of the next frame sent */
    double sent;      /* [s] when the last one was */

    question_t queue[MASTER_QUEUE];
    uint32_t first, count; /* of the queue */
    line_state_t state;
    uint32_t step;   /* [-] packet of the first question that was asked */
    double due;      /* [s] end of patience */
    double patience; /* [s] of an ordinary question over this line */
    uint32_t synchs; /* [-] in succession without an answer */

    bool connected;
    uint32_t key;                    /* [-] of master_unlock; 0: none */
    uint32_t packet_max, sample_max; /* [octets] of commands and of samples */
    bool clock_known;
    uint32_t clock;    /* [periods] by the last answer */
    double clock_at;   /* [s] when it came */
    double clock_rate; /* [-] the drive's time over ours, 1 or more */
    bool asking_clock;
    daq_t daq;
};

double master_now(void); /* [s] */

void master_put(uint8_t *at, uint32_t value, uint32_t octets); /* low octet first */
uint32_t master_take(const uint8_t *at, uint32_t octets);

/* Into the queue; answers with MASTER_NOT_SENT at once if there is no room. */
void master_ask(master_t *master, const question_t *question);

/* One packet of these octets, zeros after what is given. */
question_t master_question(uint8_t command, uint32_t length, uint32_t octets, master_answer_t answer,
                           void *context);

/* Asks, and works until the answer is there. Answer's octets go to `data` (MASTER_READ_MAX of room at least),
 * which may be NULL. */
int master_asked(master_t *master, question_t question, uint8_t *data, uint32_t *octets);

void master_break(master_t *master, const char *why);

/* The other end no longer exists: pending questions are answered with MASTER_LOST. The descriptor stays open,
 * but no longer belongs to the master. */
void master_forget(master_t *master);

/* What a packet of samples brings. */
void master_daq_packet(master_t *master, const uint8_t *packet, uint32_t length);

/* CONNECT with what follows; waits. */
bool master_connect(master_t *master, master_error_t *error);

bool master_fail(master_error_t *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* "TARGET: what became of a command", for the results that are not the row's fault. */
bool master_fail_result(const master_t *master, master_error_t *error, const char *what, int result);

/* The row of a service, by name; NULL with an error if this program has none. */
const table_row_t *master_service(const char *name, master_error_t *error);

#endif
