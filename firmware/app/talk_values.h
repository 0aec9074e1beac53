/* The values of the application at the addresses of the serial link. Only talk.c uses it. */
#ifndef APP_TALK_VALUES_H
#define APP_TALK_VALUES_H

#include "talk/xcp.h"

/* Address extensions: 0 to 3 are the tables of app_table_t, then these; texts by XCP_EXTENSION_... Addresses
 * of slots count octets, 4 x id, or 4 x place. */
#define TALK_CAPTURE 4u
#define TALK_FAULTS  7u

extern const xcp_access_t talk_access;

#endif
