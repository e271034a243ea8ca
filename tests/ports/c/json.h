/* The part of JSON that the protocol needs. */

#ifndef JSON_H
#define JSON_H

#include <stdbool.h>
#include <stddef.h>

enum json_kind { JSON_WORD, JSON_NUMBER, JSON_TEXT, JSON_ARRAY, JSON_OBJECT };

struct json {
    enum json_kind kind;
    double number;      /* of JSON_NUMBER */
    const char *text;   /* of JSON_TEXT; it lies inside the line that was parsed */
    struct json *first; /* of JSON_ARRAY and JSON_OBJECT: the first item */
    size_t count;       /* the number of items */
    const char *name;   /* the name of this value, if it is a member of an object */
    struct json *next;  /* the next item of the array or object that this value is in */
};

/* Parses a line, which is changed: texts are decoded where they stand. Refuses what is no JSON. */
struct json *parse_json(char *line);

/* Returns a member of an object, or NULL. */
const struct json *member(const struct json *object, const char *name);

/* Prints a text in quotes. */
void print_text(const char *text);

#endif
