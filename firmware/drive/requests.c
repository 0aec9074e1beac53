#include "drive/requests.h"

#include "drive/reasons.h"

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, text)                                                   \
    {id, SLOT_FLOAT, TABLE_LIVE, offsetof(requests_t, name), #name, unit, text, "", initial, min, max},
#define ROW_ENUM(id, name, choices, text)                                                                    \
    {id, SLOT_ENUM, TABLE_LIVE, offsetof(requests_t, name), #name, "-", text, choices, 0.0f, 0.0f, 0.0f},
    DRIVE_REQUESTS(ROW_FLOAT, ROW_ENUM)
#undef ROW_FLOAT
#undef ROW_ENUM
};

const table_t requests_table = {"requests", rows, sizeof rows / sizeof rows[0]};

void requests_defaults(requests_t *requests)
{
    table_defaults(&requests_table, requests);
}

bool requests_check(const requests_t *requests, const params_t *params, params_error_t *why)
{
    for (uint32_t n = 0; n < requests_table.count; n++) {
        if (!params_check_range(&rows[n], requests, why)) {
            return false;
        }
    }
    const float speed_max = 0.95f * params->overspeed_trip;
    const float current_max = params->current_limit;
    return params_check_rule(&requests_table, "speed_request", "|speed_request| <= 0.95 overspeed_trip",
                             requests->speed_request, -speed_max, speed_max, why) &&
           params_check_rule(&requests_table, "i_d_request", "|i_d_request| <= current_limit",
                             requests->i_d_request, -current_max, current_max, why) &&
           params_check_rule(&requests_table, "i_q_request", "|i_q_request| <= current_limit",
                             requests->i_q_request, -current_max, current_max, why);
}
