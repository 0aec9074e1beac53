#include "drive/reasons.h"

#include <stddef.h>

const reason_row_t reasons[] = {
#define REASON_ROW(number, NAME, name, text, remedy) {number, name, text, remedy},
    DRIVE_REASONS(REASON_ROW)
#undef REASON_ROW
};

const uint32_t reasons_count = sizeof reasons / sizeof reasons[0];

const reason_row_t *reason_by_number(int32_t number)
{
    for (uint32_t n = 0; n < reasons_count; n++) {
        if (reasons[n].number == number) {
            return &reasons[n];
        }
    }
    return NULL;
}
