#include "talk/text.h"

#include "math/float_bits.h"

void text_put(text_t *text, const char *string)
{
    for (const char *c = string; *c != '\0'; c++) {
        text_put_octet(text, (uint16_t)*c);
    }
}

void text_quoted(text_t *text, const char *string)
{
    text_put_octet(text, '"');
    for (const char *c = string; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\') {
            text_put_octet(text, '\\');
        }
        text_put_octet(text, (uint16_t)*c);
    }
    text_put_octet(text, '"');
}

#define DIGITS_MAX 20u /* of 64 bits */

/* The decimal digits, as numbers. Returns how many. */
static uint32_t digits_of(uint64_t value, uint16_t *digits)
{
    uint64_t rest = value;
    uint32_t count = 0u;
    do {
        rest /= 10u;
        count++;
    } while (rest != 0u);
    rest = value;
    for (uint32_t n = count; n > 0u; n--) {
        digits[n - 1u] = (uint16_t)(rest % 10u);
        rest /= 10u;
    }
    return count;
}

static void put_digit(text_t *text, uint16_t digit)
{
    text_put_octet(text, (uint16_t)(digit + 48u)); /* 48: the character 0 */
}

void text_whole(text_t *text, int64_t value)
{
    uint16_t digits[DIGITS_MAX];
    uint64_t amount = (uint64_t)value;
    if (value < 0) {
        text_put_octet(text, '-');
        amount = 0u - amount;
    }
    const uint32_t count = digits_of(amount, digits);
    for (uint32_t n = 0; n < count; n++) {
        put_digit(text, digits[n]);
    }
}

void text_hex(text_t *text, uint32_t value, uint32_t digits)
{
    static const char hex[] = "0123456789abcdef";
    for (uint32_t n = digits; n > 0u; n--) {
        text_put_octet(text, (uint16_t)hex[value >> 4u * (n - 1u) & 15u]);
    }
}

/* A positive number as value x 10^exponent, with half of the distance to the neighbouring floats in the same
 * unit: a number within that distance reads back as the same float. */
typedef struct {
    uint64_t value; /* 10^17 to below 10^18 */
    uint64_t half;
    int32_t exponent;
} decimal_t;

#define SMALLEST UINT64_C(100000000000000000)

/* mantissa x 2^exponent by steps of two and ten in 64 bits: the last bits are lost, at most about 40 times,
 * which is far below half a float's last bit. */
static decimal_t decimal_of(uint32_t mantissa, int32_t exponent)
{
    decimal_t d = {(uint64_t)mantissa << 33u, UINT64_C(1) << 32u, 0};
    int32_t power2 = exponent - 33;
    while (power2 != 0 || d.value < SMALLEST) {
        if (d.value < SMALLEST) { /* the upper bits are free */
            if (power2 > 0 && d.value < UINT64_C(1) << 58u) {
                d.value <<= 1u;
                d.half <<= 1u;
                power2--;
            } else {
                d.value *= 10u;
                d.half *= 10u;
                d.exponent--;
            }
        } else if (power2 < 0) {
            d.value >>= 1u;
            d.half >>= 1u;
            power2++;
        } else {
            d.value = d.value / 10u;
            d.half = d.half / 10u;
            d.exponent++;
        }
    }
    while (d.value >= 10u * SMALLEST) {
        d.value /= 10u;
        d.half /= 10u;
        d.exponent++;
    }
    return d;
}

/* The smallest number of digits that reads back as the same float. */
static uint64_t shortest(const decimal_t *d)
{
    for (uint64_t step = SMALLEST; step > 1u; step /= 10u) {
        const uint64_t rounded = (d->value + step / 2u) / step * step;
        const uint64_t away = rounded > d->value ? rounded - d->value : d->value - rounded;
        if (away < d->half - d->half / 1024u) {
            return rounded;
        }
    }
    return d->value;
}

/* Writes digits with a point, or with an exponent where zeros would be needed to fill them up. */
static void put_digits(text_t *text, const uint16_t *digits, uint32_t count, int32_t point)
{
    const bool plain = point > -4 && point <= 10;
    const int32_t before = plain ? point : 1;
    if (before <= 0) {
        text_put(text, "0.");
        for (int32_t n = before; n < 0; n++) {
            text_put_octet(text, '0');
        }
    }
    for (uint32_t n = 0; n < count; n++) {
        if ((int32_t)n == before && n > 0u) {
            text_put_octet(text, '.');
        }
        put_digit(text, digits[n]);
    }
    for (int32_t n = (int32_t)count; n < before; n++) {
        text_put_octet(text, '0');
    }
    if (!plain) {
        text_put_octet(text, 'e');
        text_whole(text, point - 1);
    }
}

void text_float(text_t *text, float value)
{
    const uint32_t bits = float_bits(value);
    const uint32_t exponent = bits >> 23u & 0xFFu;
    const uint32_t fraction = bits & UINT32_C(0x7FFFFF);
    if ((bits >> 31u) != 0u) {
        text_put_octet(text, '-');
    }
    if (exponent == 0u && fraction == 0u) {
        text_put_octet(text, '0');
        return;
    }
    const bool normal = exponent != 0u;
    const decimal_t d =
        decimal_of(normal ? fraction | UINT32_C(0x800000) : fraction, (normal ? (int32_t)exponent : 1) - 150);
    uint16_t digits[DIGITS_MAX];
    uint32_t count = digits_of(shortest(&d), digits);
    const int32_t point = (int32_t)count + d.exponent;
    while (count > 1u && digits[count - 1u] == 0u) {
        count--;
    }
    put_digits(text, digits, count, point);
}
