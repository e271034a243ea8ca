#include "json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "request.h"

/* Requests have three levels. A limit keeps a line of brackets from using up the stack. */
enum { DEEPEST = 16 };

static struct json *parse_value(char **at, int depth);

static void skip_spaces(char **at) { *at += strspn(*at, " \t\r\n"); }

static bool skip(char **at, char wanted) {
    skip_spaces(at);
    if (**at != wanted) return false;
    ++*at;
    return true;
}

static char unicode(const char *digits) {
    unsigned code = 0;
    if (strspn(digits, "0123456789abcdefABCDEF") < 4 || sscanf(digits, "%4x", &code) != 1 ||
        code == 0 || code > 127)
        refuse("texts of the protocol are ASCII");
    return (char)code;
}

/* A decoded text is never longer than the text in quotes, so it is written over it. */
static const char *parse_text(char **at) {
    static const char escapes[] = "\"\\/bfnrt", meanings[] = "\"\\/\b\f\n\r\t";
    if (!skip(at, '"')) refuse("a text is missing");
    char *text = *at, *end = text;
    while (**at != '"') {
        if (**at == '\0') refuse("a text does not end");
        if (**at != '\\') {
            *end++ = *(*at)++;
        } else if ((*at)[1] == 'u') {
            *end++ = unicode(*at + 2);
            *at += 6;
        } else {
            const char *found = (*at)[1] ? strchr(escapes, (*at)[1]) : NULL;
            if (found == NULL) refuse("an escape is unknown");
            *end++ = meanings[found - escapes];
            *at += 2;
        }
    }
    ++*at;
    *end = '\0';
    return text;
}

static double parse_number(char **at) {
    size_t size = strspn(*at, "+-.0123456789eE");
    char *end;
    double number = strtod(*at, &end);
    if (size == 0 || end != *at + size) refuse("a number is malformed");
    *at = end;
    return number;
}

/* Parses what stands between the brackets of an array, or of an object. */
static void parse_items(char **at, int depth, struct json *parent, char close) {
    struct json **last = &parent->first;
    if (skip(at, close)) return;
    do {
        const char *name = NULL;
        if (parent->kind == JSON_OBJECT) {
            name = parse_text(at);
            if (!skip(at, ':')) refuse("a colon is missing");
        }
        *last = parse_value(at, depth + 1);
        (*last)->name = name;
        last = &(*last)->next;
        ++parent->count;
    } while (skip(at, ','));
    if (!skip(at, close)) refuse("a bracket is missing");
}

static struct json *parse_value(char **at, int depth) {
    static const char *const words[] = {"null", "true", "false"};
    struct json *value = allocate(1, sizeof *value);
    if (depth > DEEPEST) refuse("the values are nested too deeply");
    skip_spaces(at);
    if (**at == '"') {
        value->kind = JSON_TEXT;
        value->text = parse_text(at);
    } else if (skip(at, '[')) {
        value->kind = JSON_ARRAY;
        parse_items(at, depth, value, ']');
    } else if (skip(at, '{')) {
        value->kind = JSON_OBJECT;
        parse_items(at, depth, value, '}');
    } else {
        value->kind = JSON_WORD;
        for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
            if (strncmp(*at, words[i], strlen(words[i])) == 0) {
                *at += strlen(words[i]);
                return value;
            }
        }
        value->kind = JSON_NUMBER;
        value->number = parse_number(at);
    }
    return value;
}

struct json *parse_json(char *line) {
    struct json *value = parse_value(&line, 0);
    skip_spaces(&line);
    if (*line != '\0') refuse("something follows the value");
    return value;
}

const struct json *member(const struct json *object, const char *name) {
    if (object == NULL || object->kind != JSON_OBJECT) return NULL;
    for (const struct json *item = object->first; item != NULL; item = item->next)
        if (strcmp(item->name, name) == 0) return item;
    return NULL;
}

void print_text(const char *text) {
    putchar('"');
    for (; *text != '\0'; ++text) {
        if (*text == '"' || *text == '\\')
            printf("\\%c", *text);
        else if ((unsigned char)*text < ' ')
            printf("\\u%04x", (unsigned)(unsigned char)*text);
        else
            putchar(*text);
    }
    putchar('"');
}
