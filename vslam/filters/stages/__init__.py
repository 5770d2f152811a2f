"""The stages of light filters, one idea a file: the dissertation's, equation by equation, and the field's."""
