/* A port of the stages S2, S3 and S5 to S11 of impact zone optimization, in C11.

   The program reads one request a line and writes one reply a line, in order, until its input
   ends. The first line is a greeting. See README.md. */

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "request.h"
#include "stages.h"

static const struct {
    const char *name;
    void (*answer)(const struct json *input);
} stages[] = {
    {"S2", time_of_impact},    {"S3", normal_and_weights},  {"S5", group_into_zones},
    {"S6", zone_at_point},     {"S7", lagrangian_at_point}, {"S8", line_search},
    {"S9", update_multipliers}, {"S10", first_iterations},   {"S11", optimum_of_zone},
};
enum { N_STAGES = sizeof stages / sizeof *stages };

/* The id of the request in work. It lies inside the line, so it outlives the request. */
static const char *current_id;

static const char *text_of(const struct json *request, const char *name) {
    const struct json *value = member(request, name);
    return value != NULL && value->kind == JSON_TEXT ? value->text : "";
}

static void greet(void) {
    printf("{\"name\":\"c-example\",\"version\":\"1\",\"stages\":[");
    for (size_t i = 0; i < N_STAGES; ++i) printf("%s\"%s\"", i == 0 ? "" : ",", stages[i].name);
    printf("],\"dtypes\":[\"%s\"]}\n", DTYPE);
}

static void print_status(const char *status, const char *message) {
    printf("{\"id\":");
    print_text(current_id);
    printf(",\"status\":\"%s\",\"message\":", status);
    print_text(message);
    printf("}\n");
}

static void answer(char *line) {
    const struct json *request = parse_json(line);
    if (member(request, "hello") != NULL) {
        greet();
        return;
    }
    current_id = text_of(request, "id");
    if (strcmp(text_of(request, "dtype"), DTYPE) != 0) {
        print_status("unsupported", "this build has the other dtype");
        return;
    }
    for (size_t i = 0; i < N_STAGES; ++i) {
        if (strcmp(text_of(request, "stage"), stages[i].name) == 0) {
            begin_reply(current_id);
            stages[i].answer(member(request, "input"));
            end_reply();
            return;
        }
    }
    print_status("unsupported", "this port has no such stage");
}

/* Reads a line of any length into a buffer that grows. Returns false at the end of the input. */
static bool read_line(char **line, size_t *capacity) {
    size_t size = 0;
    int c = getchar();
    if (c == EOF) return false;
    for (; c != EOF && c != '\n'; c = getchar()) {
        if (size + 2 > *capacity) {
            *capacity = 2 * *capacity + 4096;
            *line = realloc(*line, *capacity);
            if (*line == NULL) {
                fputs("out of memory for a request\n", stderr);
                exit(EXIT_FAILURE);
            }
        }
        (*line)[size++] = (char)c;
    }
    if (size > 0) (*line)[size] = '\0';
    return true;
}

int main(void) {
    char *line = NULL;
    size_t capacity = 0;
    while (read_line(&line, &capacity)) {
        current_id = "";
        const char *message = run_request(answer, line);
        if (message != NULL) print_status("refused", message);
        fflush(stdout); /* the next request comes after this reply has arrived */
    }
    free(line);
    return EXIT_SUCCESS;
}
