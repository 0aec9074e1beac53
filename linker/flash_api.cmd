/* TI's flash API for the F2833x by itself, to run from L0-L3 (tools/flash-api). All numbers count 16-bit words. The table of
 * linker/flash_api.asm comes first; the rest lies anywhere behind it, the library's two variables too, so that the words of the
 * block are all that it needs. Its initial values of variables are never used: the program sets both before each use. */
MEMORY
{
    L0_L3 : origin = 0x008000, length = 0x004000
}

SECTIONS
{
    flash_table : load = 0x008000
    .text       : > L0_L3
    .econst     : > L0_L3
    .cinit      : > L0_L3
    .ebss       : > L0_L3
}
