/* The part of <signal.h> with which tests detect a failed assertion. */
#ifndef TARGET_SIGNAL_H
#define TARGET_SIGNAL_H

#define SIGABRT 6
#define SIG_DFL ((signal_handler_t)0)

typedef void (*signal_handler_t)(int);
signal_handler_t signal(int number, signal_handler_t handler);

#endif
