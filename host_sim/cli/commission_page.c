#include "host_sim/cli/commission_page.h"

#include <stdio.h>

#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/json.h"

#define SCRIPT "plot/commission.py"
#define NAME   "commission"

bool commission_page_folder(const char **folder, const char *formats)
{
    static char fresh[PATH_SIZE];
    const bool made = *folder != NULL ? output_folder(*folder) : output_fresh_folder(fresh, "runs", NAME);
    if (!made) {
        return false;
    }
    *folder = *folder != NULL ? *folder : fresh;
    return output_allowed_pictures(*folder, NAME, formats);
}

static void put_number(FILE *file, const char *before, const char *name, double value)
{
    fprintf(file, "%s\"%s\": ", before, name);
    json_number(file, value);
}

static void write_data(FILE *file, const commission_page_t *page)
{
    const commission_result_t *result = page->result;
    fprintf(file, "{\"of\": ");
    json_text(file, page->of);
    fprintf(file, ", \"what\": ");
    json_text(file, result->what);
    fprintf(file, ", \"step\": ");
    json_text(file, commission_step_name((commission_do_t)result->step));
    put_number(file, ", \"plate\": {", "pole_pairs", page->plate->pole_pairs);
    put_number(file, ", ", "current", page->plate->current);
    put_number(file, ", ", "speed", page->plate->speed);
    put_number(file, "}, \"sheet\": {", "resistance", page->sheet->resistance);
    put_number(file, ", ", "inductance_d", page->sheet->inductance_d);
    put_number(file, ", ", "inductance_q", page->sheet->inductance_q);
    put_number(file, ", ", "flux_linkage", page->sheet->flux_linkage);
    put_number(file, ", ", "inertia", page->sheet->inertia);
    for (uint32_t n = 0; n < COMMISSION_STEP_COUNT; n++) {
        put_number(file, n == 0u ? "}, \"step_seconds\": {" : ", ", commission_step_name((commission_do_t)n),
                   result->step_seconds[n]);
    }
    fprintf(file, "}, \"result\": ");
    commission_print_json(file, result);
    fprintf(file, "}\n");
}

int commission_page_draw(const commission_page_t *page, const char *folder, const char *formats)
{
    const char *const arguments[] = {"--out", folder, "--format", formats, NULL};
    FILE *data = tmpfile();
    if (data == NULL) {
        fprintf(stderr, "lagless commission: no temporary file can be made\n");
        return EXIT_INTERNAL;
    }
    write_data(data, page);
    const int exit_code = output_script(SCRIPT, arguments, data);
    fclose(data);
    return exit_code;
}
