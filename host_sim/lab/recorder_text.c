/* Numbers and lines as text, the same octets on every machine.
 *
 * Floats: the shortest decimal inside the rounding interval, nearest to the float among these (Raffaele
 * Giulietti, "The Schubfach way to render doubles", 2020, here for 24 bits). With v = c 2^q and k =
 * floor(log10 of the interval's width) the interval holds a decimal of exponent k, and at most one of
 * exponent k + 1. Ends of the interval and v itself are scaled by 4 x 10^-k and truncated to integers.
 * Their last bit is 1 if digits were lost ("rounding to odd"), which keeps all comparisons exact. */
#include "host_sim/lab/recorder_parts.h"

#include <assert.h>
#include <errno.h>
#include <string.h>

#include "host_sim/lab/times.h"

/* 10^e, e = -31..45, as 64 bits without the power of two, rounded up. */
#define POWER_MIN (-31)
static const uint64_t powers[] = {
    UINT64_C(0x81CEB32C4B43FCF5), UINT64_C(0xA2425FF75E14FC32), UINT64_C(0xCAD2F7F5359A3B3F),
    UINT64_C(0xFD87B5F28300CA0E), UINT64_C(0x9E74D1B791E07E49), UINT64_C(0xC612062576589DDB),
    UINT64_C(0xF79687AED3EEC552), UINT64_C(0x9ABE14CD44753B53), UINT64_C(0xC16D9A0095928A28),
    UINT64_C(0xF1C90080BAF72CB2), UINT64_C(0x971DA05074DA7BEF), UINT64_C(0xBCE5086492111AEB),
    UINT64_C(0xEC1E4A7DB69561A6), UINT64_C(0x9392EE8E921D5D08), UINT64_C(0xB877AA3236A4B44A),
    UINT64_C(0xE69594BEC44DE15C), UINT64_C(0x901D7CF73AB0ACDA), UINT64_C(0xB424DC35095CD810),
    UINT64_C(0xE12E13424BB40E14), UINT64_C(0x8CBCCC096F5088CC), UINT64_C(0xAFEBFF0BCB24AAFF),
    UINT64_C(0xDBE6FECEBDEDD5BF), UINT64_C(0x89705F4136B4A598), UINT64_C(0xABCC77118461CEFD),
    UINT64_C(0xD6BF94D5E57A42BD), UINT64_C(0x8637BD05AF6C69B6), UINT64_C(0xA7C5AC471B478424),
    UINT64_C(0xD1B71758E219652C), UINT64_C(0x83126E978D4FDF3C), UINT64_C(0xA3D70A3D70A3D70B),
    UINT64_C(0xCCCCCCCCCCCCCCCD), UINT64_C(0x8000000000000000), UINT64_C(0xA000000000000000),
    UINT64_C(0xC800000000000000), UINT64_C(0xFA00000000000000), UINT64_C(0x9C40000000000000),
    UINT64_C(0xC350000000000000), UINT64_C(0xF424000000000000), UINT64_C(0x9896800000000000),
    UINT64_C(0xBEBC200000000000), UINT64_C(0xEE6B280000000000), UINT64_C(0x9502F90000000000),
    UINT64_C(0xBA43B74000000000), UINT64_C(0xE8D4A51000000000), UINT64_C(0x9184E72A00000000),
    UINT64_C(0xB5E620F480000000), UINT64_C(0xE35FA931A0000000), UINT64_C(0x8E1BC9BF04000000),
    UINT64_C(0xB1A2BC2EC5000000), UINT64_C(0xDE0B6B3A76400000), UINT64_C(0x8AC7230489E80000),
    UINT64_C(0xAD78EBC5AC620000), UINT64_C(0xD8D726B7177A8000), UINT64_C(0x878678326EAC9000),
    UINT64_C(0xA968163F0A57B400), UINT64_C(0xD3C21BCECCEDA100), UINT64_C(0x84595161401484A0),
    UINT64_C(0xA56FA5B99019A5C8), UINT64_C(0xCECB8F27F4200F3A), UINT64_C(0x813F3978F8940985),
    UINT64_C(0xA18F07D736B90BE6), UINT64_C(0xC9F2C9CD04674EDF), UINT64_C(0xFC6F7C4045812297),
    UINT64_C(0x9DC5ADA82B70B59E), UINT64_C(0xC5371912364CE306), UINT64_C(0xF684DF56C3E01BC7),
    UINT64_C(0x9A130B963A6C115D), UINT64_C(0xC097CE7BC90715B4), UINT64_C(0xF0BDC21ABB48DB21),
    UINT64_C(0x96769950B50D88F5), UINT64_C(0xBC143FA4E250EB32), UINT64_C(0xEB194F8E1AE525FE),
    UINT64_C(0x92EFD1B8D0CF37BF), UINT64_C(0xB7ABC627050305AE), UINT64_C(0xE596B7B0C643C71A),
    UINT64_C(0x8F7E32CE7BEA5C70), UINT64_C(0xB35DBF821AE4F38C),
};

/* floor(log10(2^q)), floor(log10(0.75 x 2^q)), floor(log2(10^e)): exact for the exponents of a float. The
 * bias keeps the shifted number positive. */
static int32_t log10_of_power(int32_t q)
{
    return ((q * 1262611 + (64 << 22)) >> 22) - 64;
}

static int32_t log10_of_narrow_power(int32_t q)
{
    return ((q * 1262611 - 524031 + (64 << 22)) >> 22) - 64;
}

static int32_t log2_of_ten(int32_t e)
{
    return ((e * 1741647 + (256 << 19)) >> 19) - 256;
}

/* g x / 2^64, cut, with its last bit set if more than the error of g was cut off. */
static uint32_t scaled(uint64_t g, uint32_t x)
{
    const uint64_t low = (g & UINT32_C(0xFFFFFFFF)) * x;
    const uint64_t high = (g >> 32) * x + (low >> 32);
    return (uint32_t)(high >> 32) | ((uint32_t)high > 1u ? 1u : 0u);
}

/* Positive float of these fields: digits x 10^exponent. */
static uint32_t shortest(uint32_t fraction, uint32_t biased, int32_t *exponent)
{
    const uint32_t c = biased != 0u ? fraction | UINT32_C(0x800000) : fraction;
    const int32_t q = biased != 0u ? (int32_t)biased - 150 : -149;
    const bool narrow = fraction == 0u && biased > 1u; /* below a power of two the floats lie closer */
    const int32_t k = narrow ? log10_of_narrow_power(q) : log10_of_power(q);
    const uint64_t g = powers[-k - POWER_MIN];
    const int32_t h = q + log2_of_ten(-k) + 1;

    const uint32_t v = scaled(g, (4u * c) << h);
    const uint32_t cut = c & 1u; /* the ends belong to an even float */
    const uint32_t lower = scaled(g, (4u * c - (narrow ? 1u : 2u)) << h) + cut;
    const uint32_t upper = scaled(g, (4u * c + 2u) << h) - cut;

    const uint32_t s = v / 4u;
    const uint32_t tens = s / 10u;
    if (s >= 10u) {
        const bool down = lower <= 40u * tens;
        const bool up = 40u * tens + 40u <= upper;
        if (down != up) {
            *exponent = k + 1;
            return tens + (up ? 1u : 0u);
        }
    }
    *exponent = k;
    const bool down = lower <= 4u * s;
    const bool up = 4u * s + 4u <= upper;
    if (down != up) {
        return s + (up ? 1u : 0u);
    }
    const uint32_t half = 4u * s + 2u;
    return s + (v > half || (v == half && (s & 1u) != 0u) ? 1u : 0u);
}

size_t recorder_uint_text(char *to, uint64_t value)
{
    char digits[20];
    size_t count = 0;
    do {
        digits[count++] = (char)('0' + value % 10u);
        value /= 10u;
    } while (value != 0u);
    for (size_t n = 0; n < count; n++) {
        to[n] = digits[count - 1u - n];
    }
    return count;
}

size_t recorder_int_text(char *to, int32_t value)
{
    if (value >= 0) {
        return recorder_uint_text(to, (uint32_t)value);
    }
    to[0] = '-';
    return 1u + recorder_uint_text(to + 1, (uint64_t)(-(int64_t)value));
}

static size_t word(char *to, const char *text)
{
    const size_t length = strlen(text);
    memcpy(to, text, length);
    return length;
}

/* digits x 10^exponent: plain from 1e-4 to below 1e9, else with an exponent. */
static size_t placed(char *to, uint32_t digits, int32_t exponent)
{
    while (digits % 10u == 0u) {
        digits /= 10u;
        exponent++;
    }
    char text[RECORDER_NUMBER_SIZE] = "";
    const int32_t count = (int32_t)recorder_uint_text(text, digits);
    const int32_t point = count + exponent; /* digits before the point */
    char *end = to;
    if (point < -3 || point > 9) {
        *end++ = text[0];
        if (count > 1) {
            *end++ = '.';
            memcpy(end, text + 1, (size_t)count - 1u);
            end += count - 1;
        }
        *end++ = 'e';
        end += recorder_int_text(end, point - 1);
    } else if (point <= 0) {
        end += word(end, "0.");
        memset(end, '0', (size_t)-point);
        end += -point;
        memcpy(end, text, (size_t)count);
        end += count;
    } else if (point < count) {
        memcpy(end, text, (size_t)point);
        end[point] = '.';
        memcpy(end + point + 1, text + point, (size_t)(count - point));
        end += count + 1;
    } else {
        memcpy(end, text, (size_t)count);
        memset(end + count, '0', (size_t)(point - count));
        end += point;
    }
    return (size_t)(end - to);
}

size_t recorder_float_text(char *to, uint32_t bits)
{
    const uint32_t fraction = bits & UINT32_C(0x7FFFFF);
    const uint32_t biased = (bits >> 23) & 0xFFu;
    if (biased == 255u && fraction != 0u) {
        return word(to, "nan");
    }
    size_t length = 0;
    if ((bits >> 31) != 0u) {
        to[length++] = '-';
    }
    if (biased == 255u) {
        return length + word(to + length, "inf");
    }
    if (biased == 0u && fraction == 0u) {
        return length + word(to + length, "0");
    }
    int32_t exponent;
    uint32_t digits = shortest(fraction, biased, &exponent);
    if ((bits & UINT32_C(0x7FFFFFFF)) == UINT32_C(0x15AE43FD)) {
        /* 7.038531e-26: the only float whose shortest decimal ends up at its neighbour in a reader that
         * rounds to double first. One digit more helps. */
        digits = UINT32_C(70385307);
        exponent = -33;
    }
    return length + placed(to + length, digits, exponent);
}

size_t recorder_slot_text(char *to, slot_kind_t kind, uint32_t slot)
{
    switch (kind) {
    case SLOT_FLOAT:
        return recorder_float_text(to, slot);
    case SLOT_UINT:
        return recorder_uint_text(to, slot);
    case SLOT_INT:
    case SLOT_ENUM: {
        int32_t value;
        memcpy(&value, &slot, sizeof value);
        return recorder_int_text(to, value);
    }
    case SLOT_KINDS:
        break;
    }
    assert(false && "kind of slot");
    return 0;
}

size_t recorder_value_text(char *to, double value)
{
    const double whole = 9007199254740992.0; /* 2^53 */
    if (value > -whole && value < whole && value == (double)(int64_t)value) {
        size_t length = 0;
        if (value < 0.0) {
            to[length++] = '-';
        }
        return length + recorder_uint_text(to + length, (uint64_t)(value < 0.0 ? -value : value));
    }
    const float nearest = (float)value;
    uint32_t bits;
    memcpy(&bits, &nearest, sizeof bits);
    return recorder_float_text(to, bits);
}

/* ---- characters ---- */

uint32_t recorder_utf8(const char **text)
{
    static const uint32_t least[4] = {0u, 0x80u, 0x800u, 0x10000u}; /* code of this number of octets more */
    const unsigned char *c = (const unsigned char *)*text;
    const uint32_t first = *c++;
    uint32_t more = first < 0x80u ? 0u : first >= 0xF0u ? 3u : first >= 0xE0u ? 2u : 1u;
    uint32_t code = more == 0u ? first : first & (0x3Fu >> more);
    bool good = first < 0x80u || (first >= 0xC2u && first < 0xF5u);
    const uint32_t lowest = least[more];
    for (; good && more > 0u; more--) {
        good = (*c & 0xC0u) == 0x80u;
        code = good ? code << 6 | (*c++ & 0x3Fu) : code;
    }
    *text = (const char *)c;
    const bool is_character =
        code >= lowest && code <= 0x10FFFFu && (code < 0xD800u || code >= 0xE000u) && code >> 1 != 0x7FFFu;
    return good && is_character ? code : RECORDER_NO_CHARACTER;
}

size_t recorder_utf8_text(char to[4], uint32_t code)
{
    if (code < 0x80u) {
        to[0] = (char)code;
        return 1;
    }
    const size_t more = code < 0x800u ? 1u : code < 0x10000u ? 2u : 3u;
    static const uint32_t marks[4] = {0u, 0xC0u, 0xE0u, 0xF0u}; /* of a first octet with this number more */
    to[0] = (char)(marks[more] | code >> 6u * more);
    for (size_t n = 1; n <= more; n++) {
        to[n] = (char)(0x80u | (code >> 6u * (more - n) & 0x3Fu));
    }
    return 1u + more;
}

/* ---- files ---- */

void recorder_out_flush(recorder_out_t *out)
{
    if (out->error == 0 && out->used != 0u) {
        errno = 0;
        if (fwrite(out->buffer, 1, out->used, out->file) != out->used) {
            out->error = errno != 0 ? errno : EIO;
        }
    }
    out->used = 0;
}

char *recorder_out_room(recorder_out_t *out, size_t octets)
{
    assert(octets <= RECORDER_BUFFER);
    if (out->used + octets > RECORDER_BUFFER) {
        recorder_out_flush(out);
    }
    return out->buffer + out->used;
}

void recorder_out_text(recorder_out_t *out, const char *text)
{
    for (; *text != '\0'; text++) {
        *recorder_out_room(out, 1) = *text;
        out->used++;
    }
}

void recorder_out_escaped(recorder_out_t *out, const char *text, size_t length, const char *also)
{
    static const char hex[] = "0123456789abcdef";
    const bool ascii = strchr(also, RECORDER_ALL_BUT_ASCII[0]) != NULL;
    for (size_t n = 0; n < length; n++) {
        const unsigned char c = (unsigned char)text[n];
        char *to = recorder_out_room(out, 4);
        if (c == '\\') {
            memcpy(to, "\\\\", 2);
            out->used += 2u;
        } else if ((c < 0x20u && (c != '\t' || ascii)) || c == 0x7Fu || (c > 0x7Fu && ascii) ||
                   strchr(also, c) != NULL) {
            memcpy(to, "\\x", 2);
            to[2] = hex[c >> 4];
            to[3] = hex[c & 15u];
            out->used += 4u;
        } else {
            *to = (char)c;
            out->used++;
        }
    }
}

static void line(recorder_out_t *out, const char *prefix, const char *key, const char *name, const char *text,
                 const char *also)
{
    recorder_out_text(out, prefix);
    recorder_out_text(out, key);
    if (name != NULL) {
        recorder_out_text(out, " ");
        recorder_out_escaped(out, name, strlen(name), also);
    }
    recorder_out_text(out, ": ");
    recorder_out_escaped(out, text, strlen(text), also);
    recorder_out_text(out, "\n");
}

void recorder_out_meta(recorder_out_t *out, const recorder_t *recorder, const char *prefix, const char *also)
{
    char text[256];
    line(out, prefix, "lagless recording", NULL, "1", also);
    line(out, prefix, "program", NULL, recorder->program, also);
    line(out, prefix, "commit", NULL, recorder->commit, also);
    snprintf(text, sizeof text, "0x%08x", (unsigned)recorder->tables_hash);
    line(out, prefix, "tables", NULL, text, also);
    line(out, prefix, "scenario", NULL, recorder->scenario, also);
    line(out, prefix, "title", NULL, recorder->title, also);
    text[recorder_uint_text(text, recorder->seed)] = '\0';
    line(out, prefix, "seed", NULL, text, also);
    text[recorder_uint_text(text, recorder->every)] = '\0';
    line(out, prefix, "every", NULL, text, also);
    times_period_text(text, RIG_PERIOD_TICKS);
    line(out, prefix, "period", NULL, strcat(text, " s"), also);
    line(out, prefix, "ended", NULL, recorder->ended, also);
    for (uint32_t n = 0; n < recorder->column_count; n++) {
        if (recorder->columns[n].row->kind == SLOT_ENUM) {
            line(out, prefix, "choices", recorder->columns[n].name, recorder->columns[n].row->choices, also);
        }
    }
    for (uint32_t n = 0; n < recorder->value_count; n++) {
        const recorder_setting_t *value = &recorder->values[n];
        text[recorder_value_text(text, value->value)] = '\0';
        strcat(text, " ");
        strncat(text, value->unit, sizeof text - strlen(text) - 1u);
        line(out, prefix, "value", value->name, text, also);
    }
    for (uint32_t n = 0; n < recorder->note_count; n++) {
        const recorder_line_t *note = &recorder->notes[n];
        line(out, prefix, note->key, note->name, note->text, also);
    }
    for (const char *from = recorder->scenario_text; *from != '\0';) {
        const char *end = strchr(from, '\n');
        size_t length = end != NULL ? (size_t)(end - from) : strlen(from);
        const char *next = from + length + (end != NULL ? 1u : 0u);
        length -= length > 0u && from[length - 1u] == '\r' ? 1u : 0u;
        recorder_out_text(out, prefix);
        recorder_out_text(out, "text: ");
        recorder_out_escaped(out, from, length, also);
        recorder_out_text(out, "\n");
        from = next;
    }
}
