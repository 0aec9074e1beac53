/* The rows of the tables as registers of Modbus, by the same rules as over XCP. Only talk.c uses it. */
#ifndef APP_TALK_MODBUS_H
#define APP_TALK_MODBUS_H

#include "talk/modbus.h"

extern const modbus_access_t talk_modbus_access;

/* True if the drive has a key and the client has not written it: then it can read, and stop the motor. */
bool talk_modbus_locked(void);

#endif
