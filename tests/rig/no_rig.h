/* Nothing is there before a test, nor after it. */
#ifndef TESTS_RIG_NO_RIG_H
#define TESTS_RIG_NO_RIG_H

#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

#endif
