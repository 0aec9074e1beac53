/* Serial devices. Linux accepts any baud rate through its termios2, whose header and <termios.h> exclude each
 * other. Therefore this code is a separate file. Other systems accept only the rates for which they have
 * constants. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/line/transport.h"

/* Largest deviation of the hardware's baud rate from the requested one: a receiver still samples the tenth
 * bit correctly.
 */
#define NEAR(baud, asked) ((baud) <= (asked) + (asked) / 50u && (baud) + (asked) / 50u >= (asked))

#ifdef __linux__

#include <asm/ioctls.h>
#include <asm/termbits.h>

int ioctl(int descriptor, unsigned long request, ...);

bool transport_serial(int descriptor, uint32_t baud, char *why, size_t size)
{
    struct termios2 setup;
    if (ioctl(descriptor, TCGETS2, &setup) != 0) {
        snprintf(why, size, "no serial device (%s)", strerror(errno));
        return false;
    }
    setup.c_iflag = IGNBRK;
    setup.c_oflag = 0;
    setup.c_lflag = 0;
    setup.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
    setup.c_ispeed = baud;
    setup.c_ospeed = baud;
    setup.c_cc[VMIN] = 1;
    setup.c_cc[VTIME] = 0;
    if (ioctl(descriptor, TCSETS2, &setup) != 0 || ioctl(descriptor, TCGETS2, &setup) != 0) {
        snprintf(why, size, "cannot be set to %u baud (%s)", (unsigned)baud, strerror(errno));
        return false;
    }
    if (!NEAR(setup.c_ospeed, baud)) {
        snprintf(why, size, "cannot be set to %u baud: its nearest rate is %u", (unsigned)baud,
                 (unsigned)setup.c_ospeed);
        return false;
    }
    (void)ioctl(descriptor, TCFLSH, TCIOFLUSH);
    return true;
}

#else

#include <termios.h>

bool transport_serial(int descriptor, uint32_t baud, char *why, size_t size)
{
    struct termios setup;
    if (tcgetattr(descriptor, &setup) != 0) {
        snprintf(why, size, "no serial device (%s)", strerror(errno));
        return false;
    }
    cfmakeraw(&setup);
    setup.c_cflag |= CLOCAL | CREAD;
    /* systems whose constants are the rates themselves accept any rate; the others refuse a rate without a
     * constant */
    if (cfsetspeed(&setup, (speed_t)baud) != 0 || tcsetattr(descriptor, TCSANOW, &setup) != 0 ||
        tcgetattr(descriptor, &setup) != 0 || !NEAR((uint32_t)cfgetospeed(&setup), baud)) {
        snprintf(why, size, "cannot be set to %u baud", (unsigned)baud);
        return false;
    }
    (void)tcflush(descriptor, TCIOFLUSH);
    return true;
}

#endif
