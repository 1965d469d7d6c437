#include "log.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace fos {

namespace {

const char *const NAMES[] = {"t_s", "ax_mps2", "ay_mps2", "az_mps2", "gx_rads", "gy_rads", "gz_rads", "temp_c"};
enum { COLUMNS = sizeof NAMES / sizeof NAMES[0], WIDEST = 64, LINE = 4096 };

[[noreturn]] void fail(const char *path, unsigned long line, const char *why)
{
    std::fprintf(stderr, "%s, line %lu: %s\n", path, line, why);
    std::exit(1);
}

// Splits at commas in place; how many cells there are, at most WIDEST.
int split(char *line, char *cells[WIDEST])
{
    line[std::strcspn(line, "\r\n")] = '\0';
    int count = 0;
    for (char *cell = line; cell != nullptr && count < WIDEST;) {
        cells[count++] = cell;
        cell = std::strchr(cell, ',');
        if (cell != nullptr)
            *cell++ = '\0';
    }
    return count;
}

double number(const char *cell)
{
    char *end = nullptr;
    double value = std::strtod(cell, &end);
    return end == cell ? NAN : value;
}

} // namespace

Log read_log(const char *path, double rate_hz)
{
    std::FILE *file = std::fopen(path, "r");
    if (file == nullptr)
        fail(path, 0, "cannot be opened");
    char line[LINE];
    char *cells[WIDEST];
    if (std::fgets(line, sizeof line, file) == nullptr)
        fail(path, 1, "is empty");
    int cell_of[COLUMNS];
    int count = split(line, cells);
    for (int column = 0; column < COLUMNS; column++) {
        cell_of[column] = -1;
        for (int k = 0; k < count; k++) {
            if (std::strcmp(cells[k], NAMES[column]) == 0)
                cell_of[column] = k;
        }
        if (cell_of[column] < 0)
            fail(path, 1, NAMES[column]);
    }
    Log log;
    log.period_ns = static_cast<uint64_t>(std::llround(1e9 / rate_hz));
    unsigned long at = 1;
    while (std::fgets(line, sizeof line, file) != nullptr) {
        at++;
        double values[COLUMNS];
        count = split(line, cells);
        for (int column = 0; column < COLUMNS; column++)
            values[column] = cell_of[column] < count ? number(cells[cell_of[column]]) : static_cast<double>(NAN);
        if (!std::isfinite(values[0]))
            fail(path, at, "no time");
        Row row;
        row.stamp_ns = std::llround(values[0] * 1e9);
        for (int axis = 0; axis < 3; axis++) {
            row.accel[axis] = static_cast<float>(values[1 + axis]);
            row.gyro[axis] = static_cast<float>(values[4 + axis]);
        }
        row.temperature_c = static_cast<float>(values[7]);
        if (!log.rows.empty() && row.stamp_ns <= log.rows.back().stamp_ns)
            fail(path, at, "time does not go on");
        log.rows.push_back(row);
    }
    std::fclose(file);
    if (log.rows.empty())
        fail(path, at, "no rows");
    return log;
}

} // namespace fos
