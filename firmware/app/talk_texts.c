#include "app/talk_texts.h"

#include "app/app.h"
#include "app/talk_values.h"
#include "settings/signals.h"
#include "talk/a2l.h"

/* Carrier in whole kHz for a name; the exact period is in the event's data. */
#define CARRIER_KHZ ((uint32_t)(1e-3f / DRIVE_PERIOD + 0.5f))

static void write_event(text_t *text)
{
    text_put(text, "isr_");
    text_whole(text, (int32_t)CARRIER_KHZ);
    text_put(text, "kHz");
}

static void write_text(uint32_t extension, text_t *text)
{
    static const a2l_table_t described[] = {
        {&signals_table, (uint32_t)APP_TABLE_SIGNALS},
        {&params_table, (uint32_t)APP_TABLE_PARAMS},
        {&requests_table, (uint32_t)APP_TABLE_REQUESTS},
        {&services_table, (uint32_t)APP_TABLE_SERVICES},
    };
    if (extension == XCP_EXTENSION_A2L) {
        const a2l_t a2l = {
            .tables = described,
            .count = (uint32_t)(sizeof described / sizeof described[0]),
            .hash = app_tables_hash(),
            .line = {talk_access.period, BOARD_SERIAL_BAUD, write_event},
            .segment = talk_access.segment(),
        };
        a2l_write(&a2l, &app->talk.a2l, text);
    } else if (extension == XCP_EXTENSION_EPK) {
        a2l_epk(app_tables_hash(), text);
    } else {
        write_event(text);
    }
}

bool talk_is_text(uint32_t extension)
{
    return extension == XCP_EXTENSION_A2L || extension == XCP_EXTENSION_EPK ||
           extension == XCP_EXTENSION_EVENT;
}

uint32_t talk_text_length(uint32_t extension)
{
    text_t text = text_window(UINT32_MAX, 0u, NULL); /* characters are counted and not stored */
    write_text(extension, &text);
    return text.at;
}

uint32_t talk_read_text(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets)
{
    text_t text = text_window(address, count, octets);
    write_text(extension, &text);
    return count <= text.at && address <= text.at - count ? XCP_OK : XCP_OUT_OF_RANGE;
}
