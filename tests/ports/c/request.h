/* One request: its memory, its inputs, and its answer.

   Everything that is allocated for a request is freed when the request is over, and whoever finds
   that a request cannot be answered calls `refuse`, from any depth. So the stages need no code for
   errors. */

#ifndef REQUEST_H
#define REQUEST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdnoreturn.h>

#include "json.h"
#include "real.h"

/* Ends the request with the status "refused" and this message. */
noreturn void refuse(const char *message);

/* Returns zeros that are freed with the request. Refuses if there is no memory. */
void *allocate(size_t count, size_t size);

static inline real *allocate_reals(size_t count) { return allocate(count, sizeof(real)); }

/* Calls work(argument), and frees its memory. Returns NULL, or the message of a refusal. */
const char *run_request(void (*work)(char *), char *argument);

/* Read inputs. Each refuses what is missing, malformed, not finite, or not of the length `count`;
   ANY_COUNT takes any length. Integers have to be from `low` to `high`. */
#define ANY_COUNT ((size_t)-1)
size_t count_of(const struct json *input, const char *name);
real *read_reals(const struct json *input, const char *name, size_t count);
real *read_any_reals(const struct json *input, const char *name, size_t count); /* NaN too */
long *read_integers(const struct json *input, const char *name, size_t count, long low, long high);
real read_real(const struct json *input, const char *name);
real read_positive(const struct json *input, const char *name);
long read_integer(const struct json *input, const char *name, long low, long high);

/* Returns which of the words, of which the last one is NULL, the text is. */
size_t read_choice(const struct json *input, const char *name, const char *const *words);

/* Write a reply. After its first output, a stage must not refuse: half a reply cannot be undone. */
void begin_reply(const char *id);
void write_reals(const char *name, const real *values, size_t count);
void write_integers(const char *name, const long *values, size_t count);
void write_real(const char *name, real value);
void write_integer(const char *name, long value);
void end_reply(void);

#endif
