#include "talk/a2l_xcp.h"

#include "contract/line.h"
#include "talk/xcp_parts.h"

/* Version of both transport layers, in hundredths. */
#define TRANSPORT_VERSION 0x100u
#define TIMEOUTS          7u /* T1 to T7, the last one after the answer "busy" */

static void number(text_t *text, uint32_t value)
{
    text_put_octet(text, ' ');
    text_whole(text, (int64_t)value);
}

static void hex(text_t *text, uint32_t value)
{
    text_put(text, " 0x");
    text_hex(text, value, 4u);
}

/* ---- the grammar ---- */

/* The optional commands that are implemented, with their codes. */
static void commands_grammar(text_t *text)
{
    const char *separator = "";
    for (uint32_t n = 0; n < XCP_COMMAND_PARTS; n++) {
        const xcp_commands_t *part = xcp_commands(n);
        for (uint32_t m = 0; m < part->count; m++) {
            if (part->rows[m].optional != NULL) {
                text_put(text, separator);
                text_put_octet(text, '"');
                text_put(text, part->rows[m].optional);
                text_put(text, "\"=");
                text_whole(text, (int64_t)part->rows[m].code);
                separator = ",";
            }
        }
    }
}

void a2l_xcp_grammar(text_t *text)
{
    text_put(text, "    /begin A2ML\n"
                   "block \"IF_DATA\" taggedunion if_data{\"XCP\" struct{taggedstruct{\n"
                   "block \"PROTOCOL_LAYER\" struct{uint;uint;uint;uint;uint;uint;uint;uint;uchar;uint;\n"
                   "enum{\"BYTE_ORDER_MSB_LAST\"=0,\"BYTE_ORDER_MSB_FIRST\"=1};\n"
                   "enum{\"ADDRESS_GRANULARITY_BYTE\"=1,\"ADDRESS_GRANULARITY_WORD\"=2,"
                   "\"ADDRESS_GRANULARITY_DWORD\"=4};\n"
                   "taggedstruct{(\"OPTIONAL_CMD\" enum{");
    commands_grammar(text);
    text_put(text,
             "})*;};};\n"
             "block \"SEGMENT\" struct{uchar;uchar;uchar;uchar;uchar;taggedstruct{\n"
             "block \"CHECKSUM\" struct{enum{\"XCP_CRC_32\"=9};taggedstruct{\"MAX_BLOCK_SIZE\" ulong;};};\n"
             "(block \"PAGE\" struct{uchar;\n"
             "enum{\"ECU_ACCESS_NOT_ALLOWED\"=0,\"ECU_ACCESS_WITHOUT_XCP_ONLY\"=1,"
             "\"ECU_ACCESS_WITH_XCP_ONLY\"=2,\"ECU_ACCESS_DONT_CARE\"=3};\n"
             "enum{\"XCP_READ_ACCESS_NOT_ALLOWED\"=0,\"XCP_READ_ACCESS_WITHOUT_ECU_ONLY\"=1,"
             "\"XCP_READ_ACCESS_WITH_ECU_ONLY\"=2,\"XCP_READ_ACCESS_DONT_CARE\"=3};\n"
             "enum{\"XCP_WRITE_ACCESS_NOT_ALLOWED\"=0,\"XCP_WRITE_ACCESS_WITHOUT_ECU_ONLY\"=1,"
             "\"XCP_WRITE_ACCESS_WITH_ECU_ONLY\"=2,\"XCP_WRITE_ACCESS_DONT_CARE\"=3};})*;};};\n"
             "block \"DAQ\" struct{enum{\"STATIC\"=0,\"DYNAMIC\"=1};uint;uint;uchar;\n"
             "enum{\"OPTIMISATION_TYPE_DEFAULT\"=0};enum{\"ADDRESS_EXTENSION_FREE\"=0};\n"
             "enum{\"IDENTIFICATION_FIELD_TYPE_ABSOLUTE\"=0};\n"
             "enum{\"GRANULARITY_ODT_ENTRY_SIZE_DAQ_DWORD\"=4};uchar;\n"
             "enum{\"NO_OVERLOAD_INDICATION\"=0,\"OVERLOAD_INDICATION_PID\"=1,"
             "\"OVERLOAD_INDICATION_EVENT\"=2};\n"
             "taggedstruct{\"PRESCALER_SUPPORTED\";\n"
             "block \"TIMESTAMP_SUPPORTED\" struct{uint;enum{\"SIZE_DWORD\"=4};\n"
             "enum{");
    for (uint32_t unit = 0; unit < XCP_UNITS; unit++) {
        text_put(text, unit == 0u ? "\"" : ",\"");
        text_put(text, xcp_unit(unit));
        text_put(text, "\"=");
        text_whole(text, (int64_t)unit);
    }
    text_put(
        text,
        "};taggedstruct{\"TIMESTAMP_FIXED\";};};\n"
        "(block \"EVENT\" struct{char[101];char[9];uint;enum{\"DAQ\"=1,\"STIM\"=2,\"DAQ_STIM\"=3};"
        "uchar;uchar;uchar;uchar;})*;};};\n"
        "block \"XCP_ON_SxI\" struct{uint;ulong;taggedstruct{\"ASYNCH_FULL_DUPLEX_MODE\" struct{\n"
        "enum{\"PARITY_NONE\"=0,\"PARITY_ODD\"=1,\"PARITY_EVEN\"=2};"
        "enum{\"ONE_STOP_BIT\"=1,\"TWO_STOP_BITS\"=2};};};\n"
        "enum{\"HEADER_LEN_CTR_WORD\"=4};enum{\"NO_CHECKSUM\"=0,\"CHECKSUM_BYTE\"=1,\"CHECKSUM_WORD\"=2};};\n"
        "block \"XCP_ON_TCP_IP\" struct{uint;uint;taggedunion{\"HOST_NAME\" char[256];"
        "\"ADDRESS\" char[15];};};\n"
        "};};};\n"
        "    /end A2ML\n");
}

/* ---- data of this drive ---- */

static void protocol_layer(text_t *text)
{
    text_put(text, "      /begin PROTOCOL_LAYER");
    hex(text, XCP_VERSION << 8u);
    for (uint32_t n = 0; n < TIMEOUTS; n++) {
        number(text, n + 1u < TIMEOUTS ? LINE_ANSWER : LINE_RETRY);
    }
    number(text, FRAME_MAX_CTO);
    number(text, FRAME_MAX_DTO);
    text_put(text, " BYTE_ORDER_MSB_LAST ADDRESS_GRANULARITY_BYTE");
    for (uint32_t n = 0; n < XCP_COMMAND_PARTS; n++) {
        const xcp_commands_t *part = xcp_commands(n);
        for (uint32_t m = 0; m < part->count; m++) {
            if (part->rows[m].optional != NULL) {
                text_put(text, "\n        OPTIONAL_CMD ");
                text_put(text, part->rows[m].optional);
            }
        }
    }
    text_put(text, "\n      /end PROTOCOL_LAYER\n");
}

static void daq(const a2l_line_t *line, text_t *text)
{
    const xcp_span_t stamp = xcp_span(line->period);
    const xcp_span_t cycle = xcp_span_rough(stamp);
    text_put(text, "      /begin DAQ DYNAMIC");
    number(text, DAQ_LISTS);
    number(text, XCP_EVENTS);
    text_put(text, " 0 OPTIMISATION_TYPE_DEFAULT ADDRESS_EXTENSION_FREE IDENTIFICATION_FIELD_TYPE_ABSOLUTE"
                   " GRANULARITY_ODT_ENTRY_SIZE_DAQ_DWORD");
    number(text, DAQ_ENTRY_SIZE);
    text_put(text, " OVERLOAD_INDICATION_EVENT PRESCALER_SUPPORTED\n        /begin TIMESTAMP_SUPPORTED");
    number(text, stamp.count);
    text_put(text, " SIZE_DWORD ");
    text_put(text, xcp_unit(stamp.unit));
    text_put(text, " TIMESTAMP_FIXED /end TIMESTAMP_SUPPORTED\n        /begin EVENT \"");
    line->event(text);
    text_put(text, "\" \"isr\"");
    number(text, XCP_EVENT_CHANNEL);
    text_put(text, " DAQ");
    number(text, DAQ_LISTS);
    number(text, cycle.count);
    number(text, cycle.unit);
    number(text, XCP_EVENT_PRIORITY);
    text_put(text, " /end EVENT\n      /end DAQ\n");
}

void a2l_xcp(const a2l_line_t *line, text_t *text)
{
    text_put(text, "    /begin IF_DATA XCP\n");
    protocol_layer(text);
    daq(line, text);
    if (line->baud != 0u) {
        text_put(text, "      /begin XCP_ON_SxI");
        hex(text, TRANSPORT_VERSION);
        number(text, line->baud);
        text_put(text, " ASYNCH_FULL_DUPLEX_MODE PARITY_NONE ONE_STOP_BIT HEADER_LEN_CTR_WORD CHECKSUM_WORD"
                       " /end XCP_ON_SxI\n");
    }
    text_put(text, "      /begin XCP_ON_TCP_IP");
    hex(text, TRANSPORT_VERSION);
    number(text, LINE_PORT);
    text_put(text, " ADDRESS \"127.0.0.1\" /end XCP_ON_TCP_IP\n    /end IF_DATA\n");
}

/* Page 0 is the page of the drive, read only; page 1 is staged and belongs to the client alone. */
void a2l_xcp_segment(const xcp_segment_t *segment, text_t *text)
{
    text_put(text, "      /begin MEMORY_SEGMENT params \"\" DATA RAM INTERN 0x");
    text_hex(text, segment->address, 8u);
    text_put(text, " 0x");
    text_hex(text, segment->length, 8u);
    text_put(text, " -1 -1 -1 -1 -1\n        /begin IF_DATA XCP /begin SEGMENT 0 2");
    number(text, segment->extension);
    text_put(text, " 0 0\n          /begin CHECKSUM XCP_CRC_32 MAX_BLOCK_SIZE");
    number(text, XCP_CHECKSUM_MAX);
    text_put(text, " /end CHECKSUM\n"
                   "          /begin PAGE 0 ECU_ACCESS_DONT_CARE XCP_READ_ACCESS_DONT_CARE"
                   " XCP_WRITE_ACCESS_NOT_ALLOWED /end PAGE\n"
                   "          /begin PAGE 1 ECU_ACCESS_NOT_ALLOWED XCP_READ_ACCESS_DONT_CARE"
                   " XCP_WRITE_ACCESS_DONT_CARE /end PAGE\n"
                   "        /end SEGMENT /end IF_DATA\n      /end MEMORY_SEGMENT\n    ");
}
