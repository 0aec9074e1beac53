/* The I2C bus inside the virtual chip: the module, i2c.c, and the memory behind the pins, i2c_memory.c. */
#ifndef HOST_SIM_CHIP_I2C_PARTS_H
#define HOST_SIM_CHIP_I2C_PARTS_H

#include "host_sim/chip/parts.h"

/* The memory receives a START and this address; false: it does not acknowledge. */
bool i2c_memory_select(chip_t *chip, uint32_t address, bool read);
bool i2c_memory_put(chip_t *chip, uint32_t octet); /* false: not acknowledged */
uint32_t i2c_memory_get(chip_t *chip);
void i2c_memory_stop(chip_t *chip);

uint32_t i2c_memory_pulls(const chip_t *chip); /* mask of port B: the data line that it holds low */
void i2c_memory_clock(chip_t *chip);           /* a clock pulse by plain pins */

#endif
