#include "math/crc.h"

uint32_t crc_add(uint32_t crc, uint16_t word)
{
    /* Checks of the 16 values of four bits, reflected polynomial EDB88320h. */
    static const uint32_t remainders[16] = {
        UINT32_C(0x00000000), UINT32_C(0x1DB71064), UINT32_C(0x3B6E20C8), UINT32_C(0x26D930AC),
        UINT32_C(0x76DC4190), UINT32_C(0x6B6B51F4), UINT32_C(0x4DB26158), UINT32_C(0x5005713C),
        UINT32_C(0xEDB88320), UINT32_C(0xF00F9344), UINT32_C(0xD6D6A3E8), UINT32_C(0xCB61B38C),
        UINT32_C(0x9B64C2B0), UINT32_C(0x86D3D2D4), UINT32_C(0xA00AE278), UINT32_C(0xBDBDF21C),
    };
    uint32_t rest = crc ^ word;
    rest = rest >> 4 ^ remainders[rest & 15u];
    rest = rest >> 4 ^ remainders[rest & 15u];
    rest = rest >> 4 ^ remainders[rest & 15u];
    rest = rest >> 4 ^ remainders[rest & 15u];
    return rest;
}
