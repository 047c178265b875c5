def write(arguments):
    raise NotImplementedError
