/* The rows of the fault table are judged. */
#include "drive/drive_seen.h"

void drive_judge(drive_t *drive, bool look)
{
    const guard_input_t input = drive_seen(drive, look);
    guard_step(&drive->guard, &input);
}
