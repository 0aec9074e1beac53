/* The functions of the standard that the unit does not support: it has neither Boolean nor String variables
 * nor derivatives, and a step has ended when its call returns. */
#include "host_sim/fmu/fmu_parts.h"

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t count,
                          fmi2Boolean values[])
{
    (void)values;
    return count == 0u ? fmi2OK : fmu_no_variable(component, references[0], "Boolean");
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference references[], size_t count,
                         fmi2String values[])
{
    (void)values;
    return count == 0u ? fmi2OK : fmu_no_variable(component, references[0], "String");
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference references[], size_t count,
                          const fmi2Boolean values[])
{
    (void)values;
    return count == 0u ? fmi2OK : fmu_no_variable(component, references[0], "Boolean");
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference references[], size_t count,
                         const fmi2String values[])
{
    (void)values;
    return count == 0u ? fmi2OK : fmu_no_variable(component, references[0], "String");
}

static fmi2Status not_offered(fmi2Component component)
{
    return fmu_say(component, fmi2Error, "the model description does not offer this function");
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknown[],
                                        size_t unknowns, const fmi2ValueReference known[], size_t knowns,
                                        const fmi2Real change[], fmi2Real result[])
{
    (void)unknown;
    (void)unknowns;
    (void)known;
    (void)knowns;
    (void)change;
    (void)result;
    return not_offered(component);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                       size_t count, const fmi2Integer order[], const fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)order;
    (void)values;
    return not_offered(component);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                        size_t count, const fmi2Integer order[], fmi2Real values[])
{
    (void)references;
    (void)count;
    (void)order;
    (void)values;
    return not_offered(component);
}

fmi2Status fmi2CancelStep(fmi2Component component)
{
    return not_offered(component);
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind;
    (void)value;
    return fmu_say(component, fmi2Discard, "no step is pending: every step has ended when its call returns");
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) {
        return not_offered(component);
    }
    *value = ((const instance_t *)component)->kept.now;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind;
    (void)value;
    return not_offered(component);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated) {
        return not_offered(component);
    }
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind;
    (void)value;
    return not_offered(component);
}
