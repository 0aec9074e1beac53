/* Connections to a drive: TCP, and serial devices with 8 data bits, no parity, one stop bit. */
#ifndef HOST_SIM_LINE_TRANSPORT_H
#define HOST_SIM_LINE_TRANSPORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TRANSPORT_BAUD      937500u /* of a device without :BAUD */
#define TRANSPORT_BAUD_MIN  1200u
#define TRANSPORT_BAUD_MAX  12000000u
#define TRANSPORT_NAME_SIZE 256u
#define TRANSPORT_WAIT      3.0 /* [s] for a TCP connection */

typedef struct {
    bool tcp;
    char place[TRANSPORT_NAME_SIZE]; /* host or device */
    char port[8];                    /* of TCP */
    uint32_t baud;                   /* of a device */
} transport_target_t;

/* "tcp://HOST:PORT", "tcp://[::1]:PORT", "DEVICE", "DEVICE:BAUD"; a device has a slash in its name. false:
 * `why` has the cause and the accepted values. */
bool transport_parse(const char *target, transport_target_t *parsed, char *why, size_t size);

/* Opens it with a non-blocking descriptor. -1: `why` has the message. A serial device is locked for this
 * program. */
int transport_open(const char *target, bool *lossless, char *why, size_t size);

/* Sets up a serial device: raw, 8N1, no flow control, this baud rate within 2 %. false: `why` has the
 * message. */
bool transport_serial(int descriptor, uint32_t baud, char *why, size_t size);

#endif
