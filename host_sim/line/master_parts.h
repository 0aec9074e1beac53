/* Data and functions that the sources of the master share: the core (master.c) and the calls (master_calls.c,
 * master_daq.c). */
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
    uint32_t octets;  /* [octets] expected length of the last answer; MASTER_ANY: any length */
    double patience;  /* [s] */
    uint32_t repeats; /* [-] so far */
    uint32_t busy;    /* [-] number of answers "busy" until now */
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
    uint32_t period;    /* [periods] of the sample that is being received */
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
    double sent;      /* [s] time of the last transmission */

    question_t queue[MASTER_QUEUE];
    uint32_t first, count; /* of the queue */
    line_state_t state;
    uint32_t step;   /* [-] packet of the first request that was sent last */
    double due;      /* [s] time until which the master waits */
    double patience; /* [s] waiting time of an ordinary request on this line */
    uint32_t synchs; /* [-] in succession without an answer */

    bool connected;
    uint32_t key;                    /* [-] of master_unlock; 0: none */
    uint32_t packet_max, sample_max; /* [octets] of commands and of samples */
    bool clock_known;
    uint32_t clock;    /* [periods] by the last answer */
    double clock_at;   /* [s] time of this answer */
    double clock_rate; /* [-] drive's time divided by real time, at least 1 */
    bool asking_clock;
    daq_t daq;
};

double master_now(void); /* [s] */

void master_put(uint8_t *at, uint32_t value, uint32_t octets); /* low octet first */
uint32_t master_take(const uint8_t *at, uint32_t octets);

/* Adds a request to the queue. If the queue is full, the answer is MASTER_NOT_SENT at once. */
void master_ask(master_t *master, const question_t *question);

/* A request of one packet with this length; octets that are not set are zero. */
question_t master_question(uint8_t command, uint32_t length, uint32_t octets, master_answer_t answer,
                           void *context);

/* Sends a request and works until the answer has arrived. `data` receives the octets of the answer; it has
 * room for at least MASTER_READ_MAX octets, or is NULL. */
int master_asked(master_t *master, question_t question, uint8_t *data, uint32_t *octets);

void master_break(master_t *master, const char *why);

/* The other end no longer exists: pending questions are answered with MASTER_LOST. The descriptor stays open,
 * but no longer belongs to the master. */
void master_forget(master_t *master);

/* Processes a packet of samples. */
void master_daq_packet(master_t *master, const uint8_t *packet, uint32_t length);

/* Sends CONNECT and the commands that follow it, and waits for the answers. */
bool master_connect(master_t *master, master_error_t *error);

bool master_fail(master_error_t *error, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Message "TARGET: result of a command", for results that do not concern a row. */
bool master_fail_result(const master_t *master, master_error_t *error, const char *what, int result);

/* The row of a service, by name; NULL with an error if this program has none. */
const table_row_t *master_service(const char *name, master_error_t *error);

#endif
