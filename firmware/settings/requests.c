#include "settings/requests.h"

#include "settings/reasons.h"

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, text)                                                   \
    {id,  SLOT_FLOAT, TABLE_LIVE, offsetof(requests_t, name), #name, unit, text, "", initial,                \
     min, max,        {0, 0, 0}},
#define ROW_ENUM(id, name, choices, text)                                                                    \
    {id,   SLOT_ENUM, TABLE_LIVE, offsetof(requests_t, name), #name, "-", text, choices, 0.0f,               \
     0.0f, 0.0f,      {0, 0, 0}},
    DRIVE_REQUESTS(ROW_FLOAT, ROW_ENUM)
#undef ROW_FLOAT
#undef ROW_ENUM
};

const table_t requests_table = {"requests", rows, sizeof rows / sizeof rows[0]};

void requests_defaults(requests_t *requests)
{
    table_defaults(&requests_table, requests);
}

/* The range of a row, for either sign, that the parameters leave, and the rule that limits
 * it; no limit for named values. */
typedef struct {
    size_t offset;
    const char *rule;
    float largest;
} limit_t;

static bool refuse(const table_row_t *row, const requests_t *requests, const limit_t *limit,
                   params_error_t *why)
{
    const bool in_range = table_holds(row, requests);
    const float room = limit != NULL ? limit->largest : table_max(row);
    *why = (params_error_t){
        .field = row->name,
        .rule = in_range && limit != NULL ? limit->rule : PARAMS_RANGE,
        .value = table_get(row, requests),
        .min = limit != NULL && -room > table_min(row) ? -room : table_min(row),
        .max = room < table_max(row) ? room : table_max(row),
        .id = row->id,
        .reason = in_range ? REASON_CROSS_RULE : REASON_OUT_OF_RANGE,
        .change = row->id,
    };
    return false;
}

bool requests_check(const requests_t *requests, const params_t *params, params_error_t *why)
{
    const assumed_t assumed = params_configured(params);
    const limit_t limits[] = {
        {offsetof(requests_t, speed_request), "|speed_request| <= 0.95 overspeed_trip",
         0.95f * params->overspeed_trip},
        {offsetof(requests_t, i_d_request), "|i_d_request| <= current_limit", params->current_limit},
        {offsetof(requests_t, i_q_request), "|i_q_request| <= current_limit", params->current_limit},
        {offsetof(requests_t, torque_request), "|torque_request| <= the torque of current_limit",
         params_torque_most(params, &assumed)},
    };
    for (uint32_t n = 0; n < requests_table.count; n++) {
        const table_row_t *row = &rows[n];
        const limit_t *limit = NULL;
        for (uint32_t m = 0; m < sizeof limits / sizeof limits[0]; m++) {
            limit = limits[m].offset == row->offset ? &limits[m] : limit;
        }
        const float value = table_get(row, requests);
        if (!table_holds(row, requests) ||
            (limit != NULL && !(value >= -limit->largest && value <= limit->largest))) {
            return refuse(row, requests, limit, why);
        }
    }
    return true;
}
