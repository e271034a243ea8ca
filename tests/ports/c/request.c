#include "request.h"

#include <setjmp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Each block of memory begins with a link to the block before it. */
union block {
    union block *before;
    max_align_t aligned;
};

static union block *blocks;
static jmp_buf refusal;
static const char *reason;
static const char *reply_id;
static bool has_outputs;

noreturn void refuse(const char *message) {
    reason = message;
    longjmp(refusal, 1);
}

void *allocate(size_t count, size_t size) {
    if (count > (SIZE_MAX - sizeof(union block)) / size) refuse("out of memory");
    union block *block = calloc(1, sizeof *block + count * size);
    if (block == NULL) refuse("out of memory");
    block->before = blocks;
    blocks = block;
    return block + 1;
}

const char *run_request(void (*work)(char *), char *argument) {
    reason = NULL;
    if (setjmp(refusal) == 0) work(argument);
    while (blocks != NULL) {
        union block *before = blocks->before;
        free(blocks);
        blocks = before;
    }
    return reason;
}

static const struct json *find(const struct json *input, const char *name) {
    const struct json *value = member(input, name);
    if (value == NULL) refuse("an input is missing");
    return value;
}

static const struct json *find_array(const struct json *input, const char *name, size_t count) {
    const struct json *array = find(input, name);
    if (array->kind != JSON_ARRAY) refuse("an input is not an array");
    if (count != ANY_COUNT && array->count != count) refuse("an array has a wrong length");
    return array;
}

/* A float is a number, or a text in C's hexadecimal notation, which strtod reads; it reads "inf"
   and "nan" too. */
static real real_of(const struct json *value) {
    double number = value->number;
    if (value->kind == JSON_TEXT) {
        char *end;
        number = strtod(value->text, &end);
        if (end == value->text || *end != '\0') refuse("a text is not a number");
    } else if (value->kind != JSON_NUMBER) {
        refuse("a value is not a number");
    }
    return (real)number;
}

/* A float that is too large for `real` has become infinite, and is refused as well. */
static real finite(real number) {
    if (!isfinite(number)) refuse("a number is not finite");
    return number;
}

static long integer_of(const struct json *value, long low, long high) {
    double number = value->number;
    if (value->kind != JSON_NUMBER || number != floor(number)) refuse("a value is no integer");
    if (!(number >= (double)low && number <= (double)high)) refuse("an integer is out of range");
    return (long)number;
}

size_t count_of(const struct json *input, const char *name) {
    return find_array(input, name, ANY_COUNT)->count;
}

real *read_any_reals(const struct json *input, const char *name, size_t count) {
    const struct json *array = find_array(input, name, count);
    real *values = allocate_reals(array->count), *value = values;
    for (const struct json *item = array->first; item != NULL; item = item->next)
        *value++ = real_of(item);
    return values;
}

real *read_reals(const struct json *input, const char *name, size_t count) {
    real *values = read_any_reals(input, name, count);
    for (size_t i = 0; i < count_of(input, name); ++i) finite(values[i]);
    return values;
}

long *read_integers(const struct json *input, const char *name, size_t count, long low, long high) {
    const struct json *array = find_array(input, name, count);
    long *values = allocate(array->count, sizeof *values), *value = values;
    for (const struct json *item = array->first; item != NULL; item = item->next)
        *value++ = integer_of(item, low, high);
    return values;
}

real read_real(const struct json *input, const char *name) {
    return finite(real_of(find(input, name)));
}

real read_positive(const struct json *input, const char *name) {
    real value = read_real(input, name);
    if (!(value > 0)) refuse("a number is not positive");
    return value;
}

long read_integer(const struct json *input, const char *name, long low, long high) {
    return integer_of(find(input, name), low, high);
}

size_t read_choice(const struct json *input, const char *name, const char *const *words) {
    const struct json *value = find(input, name);
    if (value->kind != JSON_TEXT) refuse("an input is not a word");
    for (size_t i = 0; words[i] != NULL; ++i)
        if (strcmp(value->text, words[i]) == 0) return i;
    refuse("a word is unknown");
}

void begin_reply(const char *id) {
    reply_id = id;
    has_outputs = false;
}

/* The reply begins with its first output, when nothing can be refused any more. */
static void write_name(const char *name) {
    if (!has_outputs) {
        printf("{\"id\":");
        print_text(reply_id);
        printf(",\"status\":\"ok\",\"output\":{");
    }
    printf("%s\"%s\":", has_outputs ? "," : "", name);
    has_outputs = true;
}

/* Hexadecimal floats lose no bit, and print without a division. */
static void print_real(real value) { printf("\"%a\"", (double)value); }

void write_reals(const char *name, const real *values, size_t count) {
    write_name(name);
    for (size_t i = 0; i < count; ++i) {
        putchar(i == 0 ? '[' : ',');
        print_real(values[i]);
    }
    printf("%s", count == 0 ? "[]" : "]");
}

void write_integers(const char *name, const long *values, size_t count) {
    write_name(name);
    for (size_t i = 0; i < count; ++i) printf("%c%ld", i == 0 ? '[' : ',', values[i]);
    printf("%s", count == 0 ? "[]" : "]");
}

void write_real(const char *name, real value) {
    write_name(name);
    print_real(value);
}

void write_integer(const char *name, long value) {
    write_name(name);
    printf("%ld", value);
}

void end_reply(void) { printf("}}\n"); }
