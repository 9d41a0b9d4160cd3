@register()
def scene() -> Shape:
    size = eval('1 + 1')
    exec('import socket')
    return primitive_call('cube', shape_kwargs={'scale': __import__('os').getpid()})
