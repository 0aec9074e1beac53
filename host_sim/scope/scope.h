/* The scope: connects the master of a drive with pages in a browser.
 *
 * All samples are sent to the pages when they arrive, several times per frame of the screen; trigger, hold,
 * cursors and the reduction to the screen's columns are done by the page. Values of all tables are read
 * cyclically, and changes are sent. A request of a page (set, order, stop, choice of signals) is sent to the
 * drive at once, and the drive's answer is returned.
 *
 * Two rules of safety: when all pages have been gone for SCOPE_ALONE, a motor that was switched on from here
 * is stopped; and when the scope itself no longer sends, the drive's command_timeout stops it. */
#ifndef HOST_SIM_SCOPE_SCOPE_H
#define HOST_SIM_SCOPE_SCOPE_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/line/master.h"

#define SCOPE_SIGNALS 8u  /* [-] sampled at a time */
#define SCOPE_ALONE   5.0 /* [s] without a page, then a quick stop */

typedef struct scope scope_t;

/* Makes a scope that owns the master. `page` is the text for the browser; it must exist as long as the scope.
 * NULL: *why has the message, and the master is closed. */
scope_t *scope_open(master_t *master, uint32_t port, const char *page, size_t page_size, char *why,
                    size_t size);
uint32_t scope_port(const scope_t *scope);
const char *scope_token(const scope_t *scope); /* the page is at http://127.0.0.1:PORT/TOKEN/ */

/* Runs until *stop is not 0. If the link is lost, the scope reports this and tries to connect again. */
void scope_run(scope_t *scope, const volatile sig_atomic_t *stop);

/* Stops the motor if this scope has switched it on, disconnects, and closes. */
void scope_close(scope_t *scope);

/* Number of periods between samples that a line of this speed can carry together with other data; 1 over TCP.
 * `target` as for master_open. */
uint32_t scope_every(const char *target, uint32_t signals);

#endif
