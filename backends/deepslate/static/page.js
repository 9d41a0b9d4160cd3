(()=>{var xf=Object.create;var ea=Object.defineProperty;var vf=Object.getOwnPropertyDescriptor;var yf=Object.getOwnPropertyNames;var Sf=Object.getPrototypeOf,Mf=Object.prototype.hasOwnProperty;var Ir=(n,t)=>()=>{try{return t||n((t={exports:{}}).exports,t),t.exports}catch(e){throw t=0,e}},na=(n,t)=>{for(var e in t)ea(n,e,{get:t[e],enumerable:!0})},bf=(n,t,e,i)=>{if(t&&typeof t=="object"||typeof t=="function")for(let r of yf(t))!Mf.call(n,r)&&r!==e&&ea(n,r,{get:()=>t[r],enumerable:!(i=vf(t,r))||i.enumerable});return n};var wf=(n,t,e)=>(e=n!=null?xf(Sf(n)):{},bf(t||!n||!n.__esModule?ea(e,"default",{value:n,enumerable:!0}):e,n));var Dh=Ir((NP,Lh)=>{(function(){var n="ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/",t={rotl:function(e,i){return e<<i|e>>>32-i},rotr:function(e,i){return e<<32-i|e>>>i},endian:function(e){if(e.constructor==Number)return t.rotl(e,8)&16711935|t.rotl(e,24)&4278255360;for(var i=0;i<e.length;i++)e[i]=t.endian(e[i]);return e},randomBytes:function(e){for(var i=[];e>0;e--)i.push(Math.floor(Math.random()*256));return i},bytesToWords:function(e){for(var i=[],r=0,s=0;r<e.length;r++,s+=8)i[s>>>5]|=e[r]<<24-s%32;return i},wordsToBytes:function(e){for(var i=[],r=0;r<e.length*32;r+=8)i.push(e[r>>>5]>>>24-r%32&255);return i},bytesToHex:function(e){for(var i=[],r=0;r<e.length;r++)i.push((e[r]>>>4).toString(16)),i.push((e[r]&15).toString(16));return i.join("")},hexToBytes:function(e){for(var i=[],r=0;r<e.length;r+=2)i.push(parseInt(e.substr(r,2),16));return i},bytesToBase64:function(e){for(var i=[],r=0;r<e.length;r+=3)for(var s=e[r]<<16|e[r+1]<<8|e[r+2],a=0;a<4;a++)r*8+a*6<=e.length*8?i.push(n.charAt(s>>>6*(3-a)&63)):i.push("=");return i.join("")},base64ToBytes:function(e){e=e.replace(/[^A-Z0-9+\/]/ig,"");for(var i=[],r=0,s=0;r<e.length;s=++r%4)s!=0&&i.push((n.indexOf(e.charAt(r-1))&Math.pow(2,-2*s+8)-1)<<s*2|n.indexOf(e.charAt(r))>>>6-s*2);return i}};Lh.exports=t})()});var Ho=Ir((LP,Uh)=>{var Vo={utf8:{stringToBytes:function(n){return Vo.bin.stringToBytes(unescape(encodeURIComponent(n)))},bytesToString:function(n){return decodeURIComponent(escape(Vo.bin.bytesToString(n)))}},bin:{stringToBytes:function(n){for(var t=[],e=0;e<n.length;e++)t.push(n.charCodeAt(e)&255);return t},bytesToString:function(n){for(var t=[],e=0;e<n.length;e++)t.push(String.fromCharCode(n[e]));return t.join("")}}};Uh.exports=Vo});var Bh=Ir((DP,Oh)=>{Oh.exports=function(n){return n!=null&&(Fh(n)||$v(n)||!!n._isBuffer)};function Fh(n){return!!n.constructor&&typeof n.constructor.isBuffer=="function"&&n.constructor.isBuffer(n)}function $v(n){return typeof n.readFloatLE=="function"&&typeof n.slice=="function"&&Fh(n.slice(0,0))}});var kh=Ir((UP,zh)=>{(function(){var n=Dh(),t=Ho().utf8,e=Bh(),i=Ho().bin,r=function(s,a){s.constructor==String?a&&a.encoding==="binary"?s=i.stringToBytes(s):s=t.stringToBytes(s):e(s)?s=Array.prototype.slice.call(s,0):!Array.isArray(s)&&s.constructor!==Uint8Array&&(s=s.toString());for(var o=n.bytesToWords(s),h=s.length*8,l=1732584193,c=-271733879,u=-1732584194,d=271733878,f=0;f<o.length;f++)o[f]=(o[f]<<8|o[f]>>>24)&16711935|(o[f]<<24|o[f]>>>8)&4278255360;o[h>>>5]|=128<<h%32,o[(h+64>>>9<<4)+14]=h;for(var p=r._ff,m=r._gg,g=r._hh,_=r._ii,f=0;f<o.length;f+=16){var y=l,v=c,x=u,w=d;l=p(l,c,u,d,o[f+0],7,-680876936),d=p(d,l,c,u,o[f+1],12,-389564586),u=p(u,d,l,c,o[f+2],17,606105819),c=p(c,u,d,l,o[f+3],22,-1044525330),l=p(l,c,u,d,o[f+4],7,-176418897),d=p(d,l,c,u,o[f+5],12,1200080426),u=p(u,d,l,c,o[f+6],17,-1473231341),c=p(c,u,d,l,o[f+7],22,-45705983),l=p(l,c,u,d,o[f+8],7,1770035416),d=p(d,l,c,u,o[f+9],12,-1958414417),u=p(u,d,l,c,o[f+10],17,-42063),c=p(c,u,d,l,o[f+11],22,-1990404162),l=p(l,c,u,d,o[f+12],7,1804603682),d=p(d,l,c,u,o[f+13],12,-40341101),u=p(u,d,l,c,o[f+14],17,-1502002290),c=p(c,u,d,l,o[f+15],22,1236535329),l=m(l,c,u,d,o[f+1],5,-165796510),d=m(d,l,c,u,o[f+6],9,-1069501632),u=m(u,d,l,c,o[f+11],14,643717713),c=m(c,u,d,l,o[f+0],20,-373897302),l=m(l,c,u,d,o[f+5],5,-701558691),d=m(d,l,c,u,o[f+10],9,38016083),u=m(u,d,l,c,o[f+15],14,-660478335),c=m(c,u,d,l,o[f+4],20,-405537848),l=m(l,c,u,d,o[f+9],5,568446438),d=m(d,l,c,u,o[f+14],9,-1019803690),u=m(u,d,l,c,o[f+3],14,-187363961),c=m(c,u,d,l,o[f+8],20,1163531501),l=m(l,c,u,d,o[f+13],5,-1444681467),d=m(d,l,c,u,o[f+2],9,-51403784),u=m(u,d,l,c,o[f+7],14,1735328473),c=m(c,u,d,l,o[f+12],20,-1926607734),l=g(l,c,u,d,o[f+5],4,-378558),d=g(d,l,c,u,o[f+8],11,-2022574463),u=g(u,d,l,c,o[f+11],16,1839030562),c=g(c,u,d,l,o[f+14],23,-35309556),l=g(l,c,u,d,o[f+1],4,-1530992060),d=g(d,l,c,u,o[f+4],11,1272893353),u=g(u,d,l,c,o[f+7],16,-155497632),c=g(c,u,d,l,o[f+10],23,-1094730640),l=g(l,c,u,d,o[f+13],4,681279174),d=g(d,l,c,u,o[f+0],11,-358537222),u=g(u,d,l,c,o[f+3],16,-722521979),c=g(c,u,d,l,o[f+6],23,76029189),l=g(l,c,u,d,o[f+9],4,-640364487),d=g(d,l,c,u,o[f+12],11,-421815835),u=g(u,d,l,c,o[f+15],16,530742520),c=g(c,u,d,l,o[f+2],23,-995338651),l=_(l,c,u,d,o[f+0],6,-198630844),d=_(d,l,c,u,o[f+7],10,1126891415),u=_(u,d,l,c,o[f+14],15,-1416354905),c=_(c,u,d,l,o[f+5],21,-57434055),l=_(l,c,u,d,o[f+12],6,1700485571),d=_(d,l,c,u,o[f+3],10,-1894986606),u=_(u,d,l,c,o[f+10],15,-1051523),c=_(c,u,d,l,o[f+1],21,-2054922799),l=_(l,c,u,d,o[f+8],6,1873313359),d=_(d,l,c,u,o[f+15],10,-30611744),u=_(u,d,l,c,o[f+6],15,-1560198380),c=_(c,u,d,l,o[f+13],21,1309151649),l=_(l,c,u,d,o[f+4],6,-145523070),d=_(d,l,c,u,o[f+11],10,-1120210379),u=_(u,d,l,c,o[f+2],15,718787259),c=_(c,u,d,l,o[f+9],21,-343485551),l=l+y>>>0,c=c+v>>>0,u=u+x>>>0,d=d+w>>>0}return n.endian([l,c,u,d])};r._ff=function(s,a,o,h,l,c,u){var d=s+(a&o|~a&h)+(l>>>0)+u;return(d<<c|d>>>32-c)+a},r._gg=function(s,a,o,h,l,c,u){var d=s+(a&h|o&~h)+(l>>>0)+u;return(d<<c|d>>>32-c)+a},r._hh=function(s,a,o,h,l,c,u){var d=s+(a^o^h)+(l>>>0)+u;return(d<<c|d>>>32-c)+a},r._ii=function(s,a,o,h,l,c,u){var d=s+(o^(a|~h))+(l>>>0)+u;return(d<<c|d>>>32-c)+a},r._blocksize=16,r._digestsize=16,zh.exports=function(s,a){if(s==null)throw new Error("Illegal argument "+s);var o=n.wordsToBytes(r(s,a));return a&&a.asBytes?o:a&&a.asString?i.bytesToString(o):n.bytesToHex(o)}})()});var Zl=1;var Jl=3;var ua=0,fa=1,da=2,pa=3,ma=4,ga=5,_a=6,xa=7,$l=0,Kl=1,Ql=2;var za=1,ka=2,Ga=3,Va=4,Ha=5,Wa=6,Xa=7;var jl=300;var tc=302;var va=1e3,Di=1001,ya=1002;var ec=1006;var nc=1008;var ic=1009;var rc=1023;var Or=2300,Sa=2301,ia=2302,Rl=2303,Cl=2400,Il=2401,Pl=2402;var qa="",de="srgb",Ma="srgb-linear",ba="linear",Ur="srgb";var Ui=2e3,Nl=2001;function Ef(n){return ArrayBuffer.isView(n)&&!(n instanceof DataView)}function wa(n){return document.createElementNS("http://www.w3.org/1999/xhtml",n)}var Ll={},Br=null;function sc(n){let t=n[0];if(typeof t=="string"&&t.startsWith("TSL:")){let e=n[1];e&&e.isStackTrace?n[0]+=" "+e.getLocation():n[1]='Stack trace not available. Enable "THREE.Node.captureStackTrace" to capture stack traces.'}return n}function $t(...n){n=sc(n);let t="THREE."+n.shift();if(Br)Br("warn",t,...n);else{let e=n[0];e&&e.isStackTrace?console.warn(e.getError(t)):console.warn(t,...n)}}function Lt(...n){n=sc(n);let t="THREE."+n.shift();if(Br)Br("error",t,...n);else{let e=n[0];e&&e.isStackTrace?console.error(e.getError(t)):console.error(t,...n)}}function Fr(...n){let t=n.join(" ");t in Ll||(Ll[t]=!0,$t(...n))}var Af={[ua]:ua,[da]:_a,[ma]:ma,[pa]:ga,[fa]:fa,[_a]:da,[xa]:xa,[ga]:pa},Fi=class{addEventListener(t,e){this._listeners===void 0&&(this._listeners={});let i=this._listeners;i[t]===void 0&&(i[t]=[]),i[t].indexOf(e)===-1&&i[t].push(e)}hasEventListener(t,e){let i=this._listeners;return i===void 0?!1:i[t]!==void 0&&i[t].indexOf(e)!==-1}removeEventListener(t,e){let i=this._listeners;if(i===void 0)return;let r=i[t];if(r!==void 0){let s=r.indexOf(e);s!==-1&&r.splice(s,1)}}dispatchEvent(t){let e=this._listeners;if(e===void 0)return;let i=e[t.type];if(i!==void 0){t.target=this;let r=i.slice(0);for(let s=0,a=r.length;s<a;s++)r[s].call(this,t);t.target=null}}},Zt=["00","01","02","03","04","05","06","07","08","09","0a","0b","0c","0d","0e","0f","10","11","12","13","14","15","16","17","18","19","1a","1b","1c","1d","1e","1f","20","21","22","23","24","25","26","27","28","29","2a","2b","2c","2d","2e","2f","30","31","32","33","34","35","36","37","38","39","3a","3b","3c","3d","3e","3f","40","41","42","43","44","45","46","47","48","49","4a","4b","4c","4d","4e","4f","50","51","52","53","54","55","56","57","58","59","5a","5b","5c","5d","5e","5f","60","61","62","63","64","65","66","67","68","69","6a","6b","6c","6d","6e","6f","70","71","72","73","74","75","76","77","78","79","7a","7b","7c","7d","7e","7f","80","81","82","83","84","85","86","87","88","89","8a","8b","8c","8d","8e","8f","90","91","92","93","94","95","96","97","98","99","9a","9b","9c","9d","9e","9f","a0","a1","a2","a3","a4","a5","a6","a7","a8","a9","aa","ab","ac","ad","ae","af","b0","b1","b2","b3","b4","b5","b6","b7","b8","b9","ba","bb","bc","bd","be","bf","c0","c1","c2","c3","c4","c5","c6","c7","c8","c9","ca","cb","cc","cd","ce","cf","d0","d1","d2","d3","d4","d5","d6","d7","d8","d9","da","db","dc","dd","de","df","e0","e1","e2","e3","e4","e5","e6","e7","e8","e9","ea","eb","ec","ed","ee","ef","f0","f1","f2","f3","f4","f5","f6","f7","f8","f9","fa","fb","fc","fd","fe","ff"];var S1=Math.PI/180,Tf=180/Math.PI;function Ya(){let n=Math.random()*4294967295|0,t=Math.random()*4294967295|0,e=Math.random()*4294967295|0,i=Math.random()*4294967295|0;return(Zt[n&255]+Zt[n>>8&255]+Zt[n>>16&255]+Zt[n>>24&255]+"-"+Zt[t&255]+Zt[t>>8&255]+"-"+Zt[t>>16&15|64]+Zt[t>>24&255]+"-"+Zt[e&63|128]+Zt[e>>8&255]+"-"+Zt[e>>16&255]+Zt[e>>24&255]+Zt[i&255]+Zt[i>>8&255]+Zt[i>>16&255]+Zt[i>>24&255]).toLowerCase()}function rt(n,t,e){return Math.max(t,Math.min(e,n))}function Rf(n,t){return(n%t+t)%t}function ra(n,t,e){return(1-e)*n+e*t}var Ee=class{static{this.prototype.isVector2=!0}constructor(t=0,e=0){this.x=t,this.y=e}get width(){return this.x}set width(t){this.x=t}get height(){return this.y}set height(t){this.y=t}set(t,e){return this.x=t,this.y=e,this}setScalar(t){return this.x=t,this.y=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;default:throw new Error("THREE.Vector2: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;default:throw new Error("THREE.Vector2: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y)}copy(t){return this.x=t.x,this.y=t.y,this}add(t){return this.x+=t.x,this.y+=t.y,this}addScalar(t){return this.x+=t,this.y+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this}subScalar(t){return this.x-=t,this.y-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this}multiply(t){return this.x*=t.x,this.y*=t.y,this}multiplyScalar(t){return this.x*=t,this.y*=t,this}divide(t){return this.x/=t.x,this.y/=t.y,this}divideScalar(t){return this.multiplyScalar(1/t)}applyMatrix3(t){let e=this.x,i=this.y,r=t.elements;return this.x=r[0]*e+r[3]*i+r[6],this.y=r[1]*e+r[4]*i+r[7],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this}clamp(t,e){return this.x=rt(this.x,t.x,e.x),this.y=rt(this.y,t.y,e.y),this}clampScalar(t,e){return this.x=rt(this.x,t,e),this.y=rt(this.y,t,e),this}clampLength(t,e){let i=this.length();return this.divideScalar(i||1).multiplyScalar(rt(i,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this}negate(){return this.x=-this.x,this.y=-this.y,this}dot(t){return this.x*t.x+this.y*t.y}cross(t){return this.x*t.y-this.y*t.x}lengthSq(){return this.x*this.x+this.y*this.y}length(){return Math.sqrt(this.x*this.x+this.y*this.y)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)}normalize(){return this.divideScalar(this.length()||1)}angle(){return Math.atan2(-this.y,-this.x)+Math.PI}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let i=this.dot(t)/e;return Math.acos(rt(i,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,i=this.y-t.y;return e*e+i*i}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this}lerpVectors(t,e,i){return this.x=t.x+(e.x-t.x)*i,this.y=t.y+(e.y-t.y)*i,this}equals(t){return t.x===this.x&&t.y===this.y}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this}rotateAround(t,e){let i=Math.cos(e),r=Math.sin(e),s=this.x-t.x,a=this.y-t.y;return this.x=s*i-a*r+t.x,this.y=s*r+a*i+t.y,this}random(){return this.x=Math.random(),this.y=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y}},sn=class{constructor(t=0,e=0,i=0,r=1){this.isQuaternion=!0,this._x=t,this._y=e,this._z=i,this._w=r}static slerpFlat(t,e,i,r,s,a,o){let h=i[r+0],l=i[r+1],c=i[r+2],u=i[r+3],d=s[a+0],f=s[a+1],p=s[a+2],m=s[a+3];if(u!==m||h!==d||l!==f||c!==p){let g=h*d+l*f+c*p+u*m;g<0&&(d=-d,f=-f,p=-p,m=-m,g=-g);let _=1-o;if(g<.9995){let y=Math.acos(g),v=Math.sin(y);_=Math.sin(_*y)/v,o=Math.sin(o*y)/v,h=h*_+d*o,l=l*_+f*o,c=c*_+p*o,u=u*_+m*o}else{h=h*_+d*o,l=l*_+f*o,c=c*_+p*o,u=u*_+m*o;let y=1/Math.sqrt(h*h+l*l+c*c+u*u);h*=y,l*=y,c*=y,u*=y}}t[e]=h,t[e+1]=l,t[e+2]=c,t[e+3]=u}static multiplyQuaternionsFlat(t,e,i,r,s,a){let o=i[r],h=i[r+1],l=i[r+2],c=i[r+3],u=s[a],d=s[a+1],f=s[a+2],p=s[a+3];return t[e]=o*p+c*u+h*f-l*d,t[e+1]=h*p+c*d+l*u-o*f,t[e+2]=l*p+c*f+o*d-h*u,t[e+3]=c*p-o*u-h*d-l*f,t}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get w(){return this._w}set w(t){this._w=t,this._onChangeCallback()}set(t,e,i,r){return this._x=t,this._y=e,this._z=i,this._w=r,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._w)}copy(t){return this._x=t.x,this._y=t.y,this._z=t.z,this._w=t.w,this._onChangeCallback(),this}setFromEuler(t,e=!0){let i=t._x,r=t._y,s=t._z,a=t._order,o=Math.cos,h=Math.sin,l=o(i/2),c=o(r/2),u=o(s/2),d=h(i/2),f=h(r/2),p=h(s/2);switch(a){case"XYZ":this._x=d*c*u+l*f*p,this._y=l*f*u-d*c*p,this._z=l*c*p+d*f*u,this._w=l*c*u-d*f*p;break;case"YXZ":this._x=d*c*u+l*f*p,this._y=l*f*u-d*c*p,this._z=l*c*p-d*f*u,this._w=l*c*u+d*f*p;break;case"ZXY":this._x=d*c*u-l*f*p,this._y=l*f*u+d*c*p,this._z=l*c*p+d*f*u,this._w=l*c*u-d*f*p;break;case"ZYX":this._x=d*c*u-l*f*p,this._y=l*f*u+d*c*p,this._z=l*c*p-d*f*u,this._w=l*c*u+d*f*p;break;case"YZX":this._x=d*c*u+l*f*p,this._y=l*f*u+d*c*p,this._z=l*c*p-d*f*u,this._w=l*c*u-d*f*p;break;case"XZY":this._x=d*c*u-l*f*p,this._y=l*f*u-d*c*p,this._z=l*c*p+d*f*u,this._w=l*c*u+d*f*p;break;default:$t("Quaternion: .setFromEuler() encountered an unknown order: "+a)}return e===!0&&this._onChangeCallback(),this}setFromAxisAngle(t,e){let i=e/2,r=Math.sin(i);return this._x=t.x*r,this._y=t.y*r,this._z=t.z*r,this._w=Math.cos(i),this._onChangeCallback(),this}setFromRotationMatrix(t){let e=t.elements,i=e[0],r=e[4],s=e[8],a=e[1],o=e[5],h=e[9],l=e[2],c=e[6],u=e[10],d=i+o+u;if(d>0){let f=.5/Math.sqrt(d+1);this._w=.25/f,this._x=(c-h)*f,this._y=(s-l)*f,this._z=(a-r)*f}else if(i>o&&i>u){let f=2*Math.sqrt(1+i-o-u);this._w=(c-h)/f,this._x=.25*f,this._y=(r+a)/f,this._z=(s+l)/f}else if(o>u){let f=2*Math.sqrt(1+o-i-u);this._w=(s-l)/f,this._x=(r+a)/f,this._y=.25*f,this._z=(h+c)/f}else{let f=2*Math.sqrt(1+u-i-o);this._w=(a-r)/f,this._x=(s+l)/f,this._y=(h+c)/f,this._z=.25*f}return this._onChangeCallback(),this}setFromUnitVectors(t,e){let i=t.dot(e)+1;return i<1e-8?(i=0,Math.abs(t.x)>Math.abs(t.z)?(this._x=-t.y,this._y=t.x,this._z=0,this._w=i):(this._x=0,this._y=-t.z,this._z=t.y,this._w=i)):(this._x=t.y*e.z-t.z*e.y,this._y=t.z*e.x-t.x*e.z,this._z=t.x*e.y-t.y*e.x,this._w=i),this.normalize()}angleTo(t){return 2*Math.acos(Math.abs(rt(this.dot(t),-1,1)))}rotateTowards(t,e){let i=this.angleTo(t);if(i===0)return this;let r=Math.min(1,e/i);return this.slerp(t,r),this}identity(){return this.set(0,0,0,1)}invert(){return this.conjugate()}conjugate(){return this._x*=-1,this._y*=-1,this._z*=-1,this._onChangeCallback(),this}dot(t){return this._x*t._x+this._y*t._y+this._z*t._z+this._w*t._w}lengthSq(){return this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w}length(){return Math.sqrt(this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w)}normalize(){let t=this.length();return t===0?(this._x=0,this._y=0,this._z=0,this._w=1):(t=1/t,this._x=this._x*t,this._y=this._y*t,this._z=this._z*t,this._w=this._w*t),this._onChangeCallback(),this}multiply(t){return this.multiplyQuaternions(this,t)}premultiply(t){return this.multiplyQuaternions(t,this)}multiplyQuaternions(t,e){let i=t._x,r=t._y,s=t._z,a=t._w,o=e._x,h=e._y,l=e._z,c=e._w;return this._x=i*c+a*o+r*l-s*h,this._y=r*c+a*h+s*o-i*l,this._z=s*c+a*l+i*h-r*o,this._w=a*c-i*o-r*h-s*l,this._onChangeCallback(),this}slerp(t,e){let i=t._x,r=t._y,s=t._z,a=t._w,o=this.dot(t);o<0&&(i=-i,r=-r,s=-s,a=-a,o=-o);let h=1-e;if(o<.9995){let l=Math.acos(o),c=Math.sin(l);h=Math.sin(h*l)/c,e=Math.sin(e*l)/c,this._x=this._x*h+i*e,this._y=this._y*h+r*e,this._z=this._z*h+s*e,this._w=this._w*h+a*e,this._onChangeCallback()}else this._x=this._x*h+i*e,this._y=this._y*h+r*e,this._z=this._z*h+s*e,this._w=this._w*h+a*e,this.normalize();return this}slerpQuaternions(t,e,i){return this.copy(t).slerp(e,i)}random(){let t=2*Math.PI*Math.random(),e=2*Math.PI*Math.random(),i=Math.random(),r=Math.sqrt(1-i),s=Math.sqrt(i);return this.set(r*Math.sin(t),r*Math.cos(t),s*Math.sin(e),s*Math.cos(e))}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._w===this._w}fromArray(t,e=0){return this._x=t[e],this._y=t[e+1],this._z=t[e+2],this._w=t[e+3],this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._w,t}fromBufferAttribute(t,e){return this._x=t.getX(e),this._y=t.getY(e),this._z=t.getZ(e),this._w=t.getW(e),this._onChangeCallback(),this}toJSON(){return this.toArray()}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._w}},Mt=class{static{this.prototype.isVector3=!0}constructor(t=0,e=0,i=0){this.x=t,this.y=e,this.z=i}set(t,e,i){return i===void 0&&(i=this.z),this.x=t,this.y=e,this.z=i,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;default:throw new Error("THREE.Vector3: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;default:throw new Error("THREE.Vector3: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this}multiplyVectors(t,e){return this.x=t.x*e.x,this.y=t.y*e.y,this.z=t.z*e.z,this}applyEuler(t){return this.applyQuaternion(Dl.setFromEuler(t))}applyAxisAngle(t,e){return this.applyQuaternion(Dl.setFromAxisAngle(t,e))}applyMatrix3(t){let e=this.x,i=this.y,r=this.z,s=t.elements;return this.x=s[0]*e+s[3]*i+s[6]*r,this.y=s[1]*e+s[4]*i+s[7]*r,this.z=s[2]*e+s[5]*i+s[8]*r,this}applyNormalMatrix(t){return this.applyMatrix3(t).normalize()}applyMatrix4(t){let e=this.x,i=this.y,r=this.z,s=t.elements,a=1/(s[3]*e+s[7]*i+s[11]*r+s[15]);return this.x=(s[0]*e+s[4]*i+s[8]*r+s[12])*a,this.y=(s[1]*e+s[5]*i+s[9]*r+s[13])*a,this.z=(s[2]*e+s[6]*i+s[10]*r+s[14])*a,this}applyQuaternion(t){let e=this.x,i=this.y,r=this.z,s=t.x,a=t.y,o=t.z,h=t.w,l=2*(a*r-o*i),c=2*(o*e-s*r),u=2*(s*i-a*e);return this.x=e+h*l+a*u-o*c,this.y=i+h*c+o*l-s*u,this.z=r+h*u+s*c-a*l,this}project(t){return this.applyMatrix4(t.matrixWorldInverse).applyMatrix4(t.projectionMatrix)}unproject(t){return this.applyMatrix4(t.projectionMatrixInverse).applyMatrix4(t.matrixWorld)}transformDirection(t){let e=this.x,i=this.y,r=this.z,s=t.elements;return this.x=s[0]*e+s[4]*i+s[8]*r,this.y=s[1]*e+s[5]*i+s[9]*r,this.z=s[2]*e+s[6]*i+s[10]*r,this.normalize()}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this}divideScalar(t){return this.multiplyScalar(1/t)}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this}clamp(t,e){return this.x=rt(this.x,t.x,e.x),this.y=rt(this.y,t.y,e.y),this.z=rt(this.z,t.z,e.z),this}clampScalar(t,e){return this.x=rt(this.x,t,e),this.y=rt(this.y,t,e),this.z=rt(this.z,t,e),this}clampLength(t,e){let i=this.length();return this.divideScalar(i||1).multiplyScalar(rt(i,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this}lerpVectors(t,e,i){return this.x=t.x+(e.x-t.x)*i,this.y=t.y+(e.y-t.y)*i,this.z=t.z+(e.z-t.z)*i,this}cross(t){return this.crossVectors(this,t)}crossVectors(t,e){let i=t.x,r=t.y,s=t.z,a=e.x,o=e.y,h=e.z;return this.x=r*h-s*o,this.y=s*a-i*h,this.z=i*o-r*a,this}projectOnVector(t){let e=t.lengthSq();if(e===0)return this.set(0,0,0);let i=t.dot(this)/e;return this.copy(t).multiplyScalar(i)}projectOnPlane(t){return sa.copy(this).projectOnVector(t),this.sub(sa)}reflect(t){return this.sub(sa.copy(t).multiplyScalar(2*this.dot(t)))}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let i=this.dot(t)/e;return Math.acos(rt(i,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,i=this.y-t.y,r=this.z-t.z;return e*e+i*i+r*r}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)+Math.abs(this.z-t.z)}setFromSpherical(t){return this.setFromSphericalCoords(t.radius,t.phi,t.theta)}setFromSphericalCoords(t,e,i){let r=Math.sin(e)*t;return this.x=r*Math.sin(i),this.y=Math.cos(e)*t,this.z=r*Math.cos(i),this}setFromCylindrical(t){return this.setFromCylindricalCoords(t.radius,t.theta,t.y)}setFromCylindricalCoords(t,e,i){return this.x=t*Math.sin(e),this.y=i,this.z=t*Math.cos(e),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this}setFromMatrixScale(t){let e=this.setFromMatrixColumn(t,0).length(),i=this.setFromMatrixColumn(t,1).length(),r=this.setFromMatrixColumn(t,2).length();return this.x=e,this.y=i,this.z=r,this}setFromMatrixColumn(t,e){return this.fromArray(t.elements,e*4)}setFromMatrix3Column(t,e){return this.fromArray(t.elements,e*3)}setFromEuler(t){return this.x=t._x,this.y=t._y,this.z=t._z,this}setFromColor(t){return this.x=t.r,this.y=t.g,this.z=t.b,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this}randomDirection(){let t=Math.random()*Math.PI*2,e=Math.random()*2-1,i=Math.sqrt(1-e*e);return this.x=i*Math.cos(t),this.y=e,this.z=i*Math.sin(t),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z}},sa=new Mt,Dl=new sn,$=class{static{this.prototype.isMatrix3=!0}constructor(t,e,i,r,s,a,o,h,l){this.elements=[1,0,0,0,1,0,0,0,1],t!==void 0&&this.set(t,e,i,r,s,a,o,h,l)}set(t,e,i,r,s,a,o,h,l){let c=this.elements;return c[0]=t,c[1]=r,c[2]=o,c[3]=e,c[4]=s,c[5]=h,c[6]=i,c[7]=a,c[8]=l,this}identity(){return this.set(1,0,0,0,1,0,0,0,1),this}copy(t){let e=this.elements,i=t.elements;return e[0]=i[0],e[1]=i[1],e[2]=i[2],e[3]=i[3],e[4]=i[4],e[5]=i[5],e[6]=i[6],e[7]=i[7],e[8]=i[8],this}extractBasis(t,e,i){return t.setFromMatrix3Column(this,0),e.setFromMatrix3Column(this,1),i.setFromMatrix3Column(this,2),this}setFromMatrix4(t){let e=t.elements;return this.set(e[0],e[4],e[8],e[1],e[5],e[9],e[2],e[6],e[10]),this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let i=t.elements,r=e.elements,s=this.elements,a=i[0],o=i[3],h=i[6],l=i[1],c=i[4],u=i[7],d=i[2],f=i[5],p=i[8],m=r[0],g=r[3],_=r[6],y=r[1],v=r[4],x=r[7],w=r[2],b=r[5],A=r[8];return s[0]=a*m+o*y+h*w,s[3]=a*g+o*v+h*b,s[6]=a*_+o*x+h*A,s[1]=l*m+c*y+u*w,s[4]=l*g+c*v+u*b,s[7]=l*_+c*x+u*A,s[2]=d*m+f*y+p*w,s[5]=d*g+f*v+p*b,s[8]=d*_+f*x+p*A,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[3]*=t,e[6]*=t,e[1]*=t,e[4]*=t,e[7]*=t,e[2]*=t,e[5]*=t,e[8]*=t,this}determinant(){let t=this.elements,e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8];return e*a*c-e*o*l-i*s*c+i*o*h+r*s*l-r*a*h}invert(){let t=this.elements,e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8],u=c*a-o*l,d=o*h-c*s,f=l*s-a*h,p=e*u+i*d+r*f;if(p===0)return this.set(0,0,0,0,0,0,0,0,0);let m=1/p;return t[0]=u*m,t[1]=(r*l-c*i)*m,t[2]=(o*i-r*a)*m,t[3]=d*m,t[4]=(c*e-r*h)*m,t[5]=(r*s-o*e)*m,t[6]=f*m,t[7]=(i*h-l*e)*m,t[8]=(a*e-i*s)*m,this}transpose(){let t,e=this.elements;return t=e[1],e[1]=e[3],e[3]=t,t=e[2],e[2]=e[6],e[6]=t,t=e[5],e[5]=e[7],e[7]=t,this}getNormalMatrix(t){return this.setFromMatrix4(t).invert().transpose()}transposeIntoArray(t){let e=this.elements;return t[0]=e[0],t[1]=e[3],t[2]=e[6],t[3]=e[1],t[4]=e[4],t[5]=e[7],t[6]=e[2],t[7]=e[5],t[8]=e[8],this}setUvTransform(t,e,i,r,s,a,o){let h=Math.cos(s),l=Math.sin(s);return this.set(i*h,i*l,-i*(h*a+l*o)+a+t,-r*l,r*h,-r*(-l*a+h*o)+o+e,0,0,1),this}scale(t,e){return Fr("Matrix3: .scale() is deprecated. Use .makeScale() instead."),this.premultiply(aa.makeScale(t,e)),this}rotate(t){return Fr("Matrix3: .rotate() is deprecated. Use .makeRotation() instead."),this.premultiply(aa.makeRotation(-t)),this}translate(t,e){return Fr("Matrix3: .translate() is deprecated. Use .makeTranslation() instead."),this.premultiply(aa.makeTranslation(t,e)),this}makeTranslation(t,e){return t.isVector2?this.set(1,0,t.x,0,1,t.y,0,0,1):this.set(1,0,t,0,1,e,0,0,1),this}makeRotation(t){let e=Math.cos(t),i=Math.sin(t);return this.set(e,-i,0,i,e,0,0,0,1),this}makeScale(t,e){return this.set(t,0,0,0,e,0,0,0,1),this}equals(t){let e=this.elements,i=t.elements;for(let r=0;r<9;r++)if(e[r]!==i[r])return!1;return!0}fromArray(t,e=0){for(let i=0;i<9;i++)this.elements[i]=t[i+e];return this}toArray(t=[],e=0){let i=this.elements;return t[e]=i[0],t[e+1]=i[1],t[e+2]=i[2],t[e+3]=i[3],t[e+4]=i[4],t[e+5]=i[5],t[e+6]=i[6],t[e+7]=i[7],t[e+8]=i[8],t}clone(){return new this.constructor().fromArray(this.elements)}},aa=new $,Ul=new $().set(.4123908,.3575843,.1804808,.212639,.7151687,.0721923,.0193308,.1191948,.9505322),Fl=new $().set(3.2409699,-1.5373832,-.4986108,-.9692436,1.8759675,.0415551,.0556301,-.203977,1.0569715);function Cf(){let n={enabled:!0,workingColorSpace:Ma,spaces:{},convert:function(r,s,a){return this.enabled===!1||s===a||!s||!a||(this.spaces[s].transfer===Ur&&(r.r=qe(r.r),r.g=qe(r.g),r.b=qe(r.b)),this.spaces[s].primaries!==this.spaces[a].primaries&&(r.applyMatrix3(this.spaces[s].toXYZ),r.applyMatrix3(this.spaces[a].fromXYZ)),this.spaces[a].transfer===Ur&&(r.r=ei(r.r),r.g=ei(r.g),r.b=ei(r.b))),r},workingToColorSpace:function(r,s){return this.convert(r,this.workingColorSpace,s)},colorSpaceToWorking:function(r,s){return this.convert(r,s,this.workingColorSpace)},getPrimaries:function(r){return this.spaces[r].primaries},getTransfer:function(r){return r===qa?ba:this.spaces[r].transfer},getToneMappingMode:function(r){return this.spaces[r].outputColorSpaceConfig.toneMappingMode||"standard"},getLuminanceCoefficients:function(r,s=this.workingColorSpace){return r.fromArray(this.spaces[s].luminanceCoefficients)},define:function(r){Object.assign(this.spaces,r)},_getMatrix:function(r,s,a){return r.copy(this.spaces[a].fromXYZ).multiply(this.spaces[s].toXYZ)},_getDrawingBufferColorSpace:function(r){return this.spaces[r].outputColorSpaceConfig.drawingBufferColorSpace},_getUnpackColorSpace:function(r=this.workingColorSpace){return this.spaces[r].workingColorSpaceConfig.unpackColorSpace}},t=[.64,.33,.3,.6,.15,.06],e=[.2126,.7152,.0722],i=[.3127,.329];return n.define({[Ma]:{primaries:t,whitePoint:i,transfer:ba,toXYZ:Ul,fromXYZ:Fl,luminanceCoefficients:e,workingColorSpaceConfig:{unpackColorSpace:de},outputColorSpaceConfig:{drawingBufferColorSpace:de}},[de]:{primaries:t,whitePoint:i,transfer:Ur,toXYZ:Ul,fromXYZ:Fl,luminanceCoefficients:e,outputColorSpaceConfig:{drawingBufferColorSpace:de}}}),n}var fe=Cf();function qe(n){return n<.04045?n*.0773993808:Math.pow(n*.9478672986+.0521327014,2.4)}function ei(n){return n<.0031308?n*12.92:1.055*Math.pow(n,.41666)-.055}var $n,Ea=class{static getDataURL(t,e="image/png"){if(/^data:/i.test(t.src)||typeof HTMLCanvasElement>"u")return t.src;let i;if(t instanceof HTMLCanvasElement)i=t;else{$n===void 0&&($n=wa("canvas")),$n.width=t.width,$n.height=t.height;let r=$n.getContext("2d");t instanceof ImageData?r.putImageData(t,0,0):r.drawImage(t,0,0,t.width,t.height),i=$n}return i.toDataURL(e)}static sRGBToLinear(t){if(typeof HTMLImageElement<"u"&&t instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&t instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&t instanceof ImageBitmap){let e=wa("canvas");e.width=t.width,e.height=t.height;let i=e.getContext("2d");i.drawImage(t,0,0,t.width,t.height);let r=i.getImageData(0,0,t.width,t.height),s=r.data;for(let a=0;a<s.length;a++)s[a]=qe(s[a]/255)*255;return i.putImageData(r,0,0),e}else if(t.data){let e=t.data.slice(0);for(let i=0;i<e.length;i++)e instanceof Uint8Array||e instanceof Uint8ClampedArray?e[i]=Math.floor(qe(e[i]/255)*255):e[i]=qe(e[i]);return{data:e,width:t.width,height:t.height}}else return $t("ImageUtils.sRGBToLinear(): Unsupported image type. No color space conversion applied."),t}},If=0,Aa=class{constructor(t=null){this.isTextureSource=!0,Object.defineProperty(this,"id",{value:If++}),this.uuid=Ya(),this.data=t,this.dataReady=!0,this.version=0}getSize(t){let e=this.data;return typeof HTMLVideoElement<"u"&&e instanceof HTMLVideoElement?t.set(e.videoWidth,e.videoHeight,0):typeof VideoFrame<"u"&&e instanceof VideoFrame?t.set(e.displayWidth,e.displayHeight,0):e!==null?t.set(e.width||0,e.height||0,e.depth||0):t.set(0,0,0),t}set needsUpdate(t){t===!0&&this.version++}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.images[this.uuid]!==void 0)return t.images[this.uuid];let i={uuid:this.uuid,url:""},r=this.data;if(r!==null){let s;if(Array.isArray(r)){s=[];for(let a=0,o=r.length;a<o;a++)r[a].isDataTexture?s.push(oa(r[a].image)):s.push(oa(r[a]))}else s=oa(r);i.url=s}return e||(t.images[this.uuid]=i),i}};function oa(n){return typeof HTMLImageElement<"u"&&n instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&n instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&n instanceof ImageBitmap?Ea.getDataURL(n):n.data?{data:Array.from(n.data),width:n.width,height:n.height,type:n.data.constructor.name}:($t("Texture: Unable to serialize Texture."),{})}var Pf=0,la=new Mt,ni=class n extends Fi{constructor(t=n.DEFAULT_IMAGE,e=n.DEFAULT_MAPPING,i=Di,r=Di,s=ec,a=nc,o=rc,h=ic,l=n.DEFAULT_ANISOTROPY,c=qa){super(),this.isTexture=!0,Object.defineProperty(this,"id",{value:Pf++}),this.uuid=Ya(),this.name="",this.source=new Aa(t),this.mipmaps=[],this.mapping=e,this.channel=0,this.wrapS=i,this.wrapT=r,this.magFilter=s,this.minFilter=a,this.anisotropy=l,this.format=o,this.internalFormat=null,this.type=h,this.offset=new Ee(0,0),this.repeat=new Ee(1,1),this.center=new Ee(0,0),this.rotation=0,this.matrixAutoUpdate=!0,this.matrix=new $,this.generateMipmaps=!0,this.mipmapsAutoUpdate=!0,this.premultiplyAlpha=!1,this.flipY=!0,this.unpackAlignment=4,this.colorSpace=c,this.userData={},this.updateRanges=[],this.version=0,this.onUpdate=null,this.renderTarget=null,this.isRenderTargetTexture=!1,this.isArrayTexture=!!(t&&t.depth&&t.depth>1),this.pmremVersion=0,this.isPMREMTexture=!1,this.normalized=!1}get width(){return this.source.getSize(la).x}get height(){return this.source.getSize(la).y}get depth(){return this.source.getSize(la).z}get image(){return this.source.data}set image(t){this.source.data=t}updateMatrix(){this.matrix.setUvTransform(this.offset.x,this.offset.y,this.repeat.x,this.repeat.y,this.rotation,this.center.x,this.center.y)}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}clone(){return new this.constructor().copy(this)}copy(t){return this.name=t.name,this.source=t.source,this.mipmaps=t.mipmaps.slice(0),this.mapping=t.mapping,this.channel=t.channel,this.wrapS=t.wrapS,this.wrapT=t.wrapT,this.magFilter=t.magFilter,this.minFilter=t.minFilter,this.anisotropy=t.anisotropy,this.format=t.format,this.internalFormat=t.internalFormat,this.type=t.type,this.normalized=t.normalized,this.offset.copy(t.offset),this.repeat.copy(t.repeat),this.center.copy(t.center),this.rotation=t.rotation,this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrix.copy(t.matrix),this.generateMipmaps=t.generateMipmaps,this.mipmapsAutoUpdate=t.mipmapsAutoUpdate,this.premultiplyAlpha=t.premultiplyAlpha,this.flipY=t.flipY,this.unpackAlignment=t.unpackAlignment,this.colorSpace=t.colorSpace,this.renderTarget=t.renderTarget,this.isRenderTargetTexture=t.isRenderTargetTexture,this.isPMREMTexture=t.isPMREMTexture,this.isArrayTexture=t.isArrayTexture,this.userData=JSON.parse(JSON.stringify(t.userData)),this.needsUpdate=!0,this}setValues(t){for(let e in t){let i=t[e];if(i===void 0){$t(`Texture.setValues(): parameter '${e}' has value of undefined.`);continue}let r=this[e];if(r===void 0){$t(`Texture.setValues(): property '${e}' does not exist.`);continue}r&&i&&r.isVector2&&i.isVector2||r&&i&&r.isVector3&&i.isVector3||r&&i&&r.isMatrix3&&i.isMatrix3?r.copy(i):this[e]=i}}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.textures[this.uuid]!==void 0)return t.textures[this.uuid];let i={metadata:{version:4.7,type:"Texture",generator:"Texture.toJSON"},uuid:this.uuid,name:this.name,image:this.source.toJSON(t).uuid,mapping:this.mapping,channel:this.channel,repeat:[this.repeat.x,this.repeat.y],offset:[this.offset.x,this.offset.y],center:[this.center.x,this.center.y],rotation:this.rotation,wrap:[this.wrapS,this.wrapT],format:this.format,internalFormat:this.internalFormat,type:this.type,normalized:this.normalized,colorSpace:this.colorSpace,minFilter:this.minFilter,magFilter:this.magFilter,anisotropy:this.anisotropy,flipY:this.flipY,generateMipmaps:this.generateMipmaps,mipmapsAutoUpdate:this.mipmapsAutoUpdate,premultiplyAlpha:this.premultiplyAlpha,unpackAlignment:this.unpackAlignment};return Object.keys(this.userData).length>0&&(i.userData=this.userData),e||(t.textures[this.uuid]=i),i}dispose(){this.dispatchEvent({type:"dispose"})}transformUv(t){if(this.mapping!==jl)return t;if(t.applyMatrix3(this.matrix),t.x<0||t.x>1)switch(this.wrapS){case va:t.x=t.x-Math.floor(t.x);break;case Di:t.x=t.x<0?0:1;break;case ya:Math.abs(Math.floor(t.x)%2)===1?t.x=Math.ceil(t.x)-t.x:t.x=t.x-Math.floor(t.x);break}if(t.y<0||t.y>1)switch(this.wrapT){case va:t.y=t.y-Math.floor(t.y);break;case Di:t.y=t.y<0?0:1;break;case ya:Math.abs(Math.floor(t.y)%2)===1?t.y=Math.ceil(t.y)-t.y:t.y=t.y-Math.floor(t.y);break}return this.flipY&&(t.y=1-t.y),t}set needsUpdate(t){t===!0&&(this.version++,this.source.needsUpdate=!0)}set needsPMREMUpdate(t){t===!0&&this.pmremVersion++}};ni.DEFAULT_IMAGE=null;ni.DEFAULT_MAPPING=jl;ni.DEFAULT_ANISOTROPY=1;var Ta=class{static{this.prototype.isVector4=!0}constructor(t=0,e=0,i=0,r=1){this.x=t,this.y=e,this.z=i,this.w=r}get width(){return this.z}set width(t){this.z=t}get height(){return this.w}set height(t){this.w=t}set(t,e,i,r){return this.x=t,this.y=e,this.z=i,this.w=r,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this.w=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setW(t){return this.w=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;case 3:this.w=e;break;default:throw new Error("THREE.Vector4: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;case 3:return this.w;default:throw new Error("THREE.Vector4: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z,this.w)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this.w=t.w!==void 0?t.w:1,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this.w+=t.w,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this.w+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this.w=t.w+e.w,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this.w+=t.w*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this.w-=t.w,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this.w-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this.w=t.w-e.w,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this.w*=t.w,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this.w*=t,this}applyMatrix4(t){let e=this.x,i=this.y,r=this.z,s=this.w,a=t.elements;return this.x=a[0]*e+a[4]*i+a[8]*r+a[12]*s,this.y=a[1]*e+a[5]*i+a[9]*r+a[13]*s,this.z=a[2]*e+a[6]*i+a[10]*r+a[14]*s,this.w=a[3]*e+a[7]*i+a[11]*r+a[15]*s,this}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this.w/=t.w,this}divideScalar(t){return this.multiplyScalar(1/t)}setAxisAngleFromQuaternion(t){this.w=2*Math.acos(t.w);let e=Math.sqrt(1-t.w*t.w);return e<1e-4?(this.x=1,this.y=0,this.z=0):(this.x=t.x/e,this.y=t.y/e,this.z=t.z/e),this}setAxisAngleFromRotationMatrix(t){let e,i,r,s,h=t.elements,l=h[0],c=h[4],u=h[8],d=h[1],f=h[5],p=h[9],m=h[2],g=h[6],_=h[10];if(Math.abs(c-d)<.01&&Math.abs(u-m)<.01&&Math.abs(p-g)<.01){if(Math.abs(c+d)<.1&&Math.abs(u+m)<.1&&Math.abs(p+g)<.1&&Math.abs(l+f+_-3)<.1)return this.set(1,0,0,0),this;e=Math.PI;let v=(l+1)/2,x=(f+1)/2,w=(_+1)/2,b=(c+d)/4,A=(u+m)/4,I=(p+g)/4;return v>x&&v>w?v<.01?(i=0,r=.707106781,s=.707106781):(i=Math.sqrt(v),r=b/i,s=A/i):x>w?x<.01?(i=.707106781,r=0,s=.707106781):(r=Math.sqrt(x),i=b/r,s=I/r):w<.01?(i=.707106781,r=.707106781,s=0):(s=Math.sqrt(w),i=A/s,r=I/s),this.set(i,r,s,e),this}let y=Math.sqrt((g-p)*(g-p)+(u-m)*(u-m)+(d-c)*(d-c));return Math.abs(y)<.001&&(y=1),this.x=(g-p)/y,this.y=(u-m)/y,this.z=(d-c)/y,this.w=Math.acos((l+f+_-1)/2),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this.w=e[15],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this.w=Math.min(this.w,t.w),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this.w=Math.max(this.w,t.w),this}clamp(t,e){return this.x=rt(this.x,t.x,e.x),this.y=rt(this.y,t.y,e.y),this.z=rt(this.z,t.z,e.z),this.w=rt(this.w,t.w,e.w),this}clampScalar(t,e){return this.x=rt(this.x,t,e),this.y=rt(this.y,t,e),this.z=rt(this.z,t,e),this.w=rt(this.w,t,e),this}clampLength(t,e){let i=this.length();return this.divideScalar(i||1).multiplyScalar(rt(i,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this.w=Math.floor(this.w),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this.w=Math.ceil(this.w),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this.w=Math.round(this.w),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this.w=Math.trunc(this.w),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this.w=-this.w,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z+this.w*t.w}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)+Math.abs(this.w)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this.w+=(t.w-this.w)*e,this}lerpVectors(t,e,i){return this.x=t.x+(e.x-t.x)*i,this.y=t.y+(e.y-t.y)*i,this.z=t.z+(e.z-t.z)*i,this.w=t.w+(e.w-t.w)*i,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z&&t.w===this.w}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this.w=t[e+3],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t[e+3]=this.w,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this.w=t.getW(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this.w=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z,yield this.w}};var Ye=class n{static{this.prototype.isMatrix4=!0}constructor(t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g){this.elements=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],t!==void 0&&this.set(t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g)}set(t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g){let _=this.elements;return _[0]=t,_[4]=e,_[8]=i,_[12]=r,_[1]=s,_[5]=a,_[9]=o,_[13]=h,_[2]=l,_[6]=c,_[10]=u,_[14]=d,_[3]=f,_[7]=p,_[11]=m,_[15]=g,this}identity(){return this.set(1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1),this}clone(){return new n().fromArray(this.elements)}copy(t){let e=this.elements,i=t.elements;return e[0]=i[0],e[1]=i[1],e[2]=i[2],e[3]=i[3],e[4]=i[4],e[5]=i[5],e[6]=i[6],e[7]=i[7],e[8]=i[8],e[9]=i[9],e[10]=i[10],e[11]=i[11],e[12]=i[12],e[13]=i[13],e[14]=i[14],e[15]=i[15],this}copyPosition(t){let e=this.elements,i=t.elements;return e[12]=i[12],e[13]=i[13],e[14]=i[14],this}setFromMatrix3(t){let e=t.elements;return this.set(e[0],e[3],e[6],0,e[1],e[4],e[7],0,e[2],e[5],e[8],0,0,0,0,1),this}extractBasis(t,e,i){return this.determinantAffine()===0?(t.set(1,0,0),e.set(0,1,0),i.set(0,0,1),this):(t.setFromMatrixColumn(this,0),e.setFromMatrixColumn(this,1),i.setFromMatrixColumn(this,2),this)}makeBasis(t,e,i){return this.set(t.x,e.x,i.x,0,t.y,e.y,i.y,0,t.z,e.z,i.z,0,0,0,0,1),this}extractRotation(t){if(t.determinantAffine()===0)return this.identity();let e=this.elements,i=t.elements,r=1/Kn.setFromMatrixColumn(t,0).length(),s=1/Kn.setFromMatrixColumn(t,1).length(),a=1/Kn.setFromMatrixColumn(t,2).length();return e[0]=i[0]*r,e[1]=i[1]*r,e[2]=i[2]*r,e[3]=0,e[4]=i[4]*s,e[5]=i[5]*s,e[6]=i[6]*s,e[7]=0,e[8]=i[8]*a,e[9]=i[9]*a,e[10]=i[10]*a,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromEuler(t){let e=this.elements,i=t.x,r=t.y,s=t.z,a=Math.cos(i),o=Math.sin(i),h=Math.cos(r),l=Math.sin(r),c=Math.cos(s),u=Math.sin(s);if(t.order==="XYZ"){let d=a*c,f=a*u,p=o*c,m=o*u;e[0]=h*c,e[4]=-h*u,e[8]=l,e[1]=f+p*l,e[5]=d-m*l,e[9]=-o*h,e[2]=m-d*l,e[6]=p+f*l,e[10]=a*h}else if(t.order==="YXZ"){let d=h*c,f=h*u,p=l*c,m=l*u;e[0]=d+m*o,e[4]=p*o-f,e[8]=a*l,e[1]=a*u,e[5]=a*c,e[9]=-o,e[2]=f*o-p,e[6]=m+d*o,e[10]=a*h}else if(t.order==="ZXY"){let d=h*c,f=h*u,p=l*c,m=l*u;e[0]=d-m*o,e[4]=-a*u,e[8]=p+f*o,e[1]=f+p*o,e[5]=a*c,e[9]=m-d*o,e[2]=-a*l,e[6]=o,e[10]=a*h}else if(t.order==="ZYX"){let d=a*c,f=a*u,p=o*c,m=o*u;e[0]=h*c,e[4]=p*l-f,e[8]=d*l+m,e[1]=h*u,e[5]=m*l+d,e[9]=f*l-p,e[2]=-l,e[6]=o*h,e[10]=a*h}else if(t.order==="YZX"){let d=a*h,f=a*l,p=o*h,m=o*l;e[0]=h*c,e[4]=m-d*u,e[8]=p*u+f,e[1]=u,e[5]=a*c,e[9]=-o*c,e[2]=-l*c,e[6]=f*u+p,e[10]=d-m*u}else if(t.order==="XZY"){let d=a*h,f=a*l,p=o*h,m=o*l;e[0]=h*c,e[4]=-u,e[8]=l*c,e[1]=d*u+m,e[5]=a*c,e[9]=f*u-p,e[2]=p*u-f,e[6]=o*c,e[10]=m*u+d}return e[3]=0,e[7]=0,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromQuaternion(t){return this.compose(Nf,t,Lf)}lookAt(t,e,i){let r=this.elements;return se.subVectors(t,e),se.lengthSq()===0&&(se.z=1),se.normalize(),nn.crossVectors(i,se),nn.lengthSq()===0&&(Math.abs(i.z)===1?se.x+=1e-4:se.z+=1e-4,se.normalize(),nn.crossVectors(i,se)),nn.normalize(),Pr.crossVectors(se,nn),r[0]=nn.x,r[4]=Pr.x,r[8]=se.x,r[1]=nn.y,r[5]=Pr.y,r[9]=se.y,r[2]=nn.z,r[6]=Pr.z,r[10]=se.z,this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let i=t.elements,r=e.elements,s=this.elements,a=i[0],o=i[4],h=i[8],l=i[12],c=i[1],u=i[5],d=i[9],f=i[13],p=i[2],m=i[6],g=i[10],_=i[14],y=i[3],v=i[7],x=i[11],w=i[15],b=r[0],A=r[4],I=r[8],C=r[12],P=r[1],L=r[5],G=r[9],q=r[13],V=r[2],B=r[6],pt=r[10],at=r[14],N=r[3],O=r[7],H=r[11],gt=r[15];return s[0]=a*b+o*P+h*V+l*N,s[4]=a*A+o*L+h*B+l*O,s[8]=a*I+o*G+h*pt+l*H,s[12]=a*C+o*q+h*at+l*gt,s[1]=c*b+u*P+d*V+f*N,s[5]=c*A+u*L+d*B+f*O,s[9]=c*I+u*G+d*pt+f*H,s[13]=c*C+u*q+d*at+f*gt,s[2]=p*b+m*P+g*V+_*N,s[6]=p*A+m*L+g*B+_*O,s[10]=p*I+m*G+g*pt+_*H,s[14]=p*C+m*q+g*at+_*gt,s[3]=y*b+v*P+x*V+w*N,s[7]=y*A+v*L+x*B+w*O,s[11]=y*I+v*G+x*pt+w*H,s[15]=y*C+v*q+x*at+w*gt,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[4]*=t,e[8]*=t,e[12]*=t,e[1]*=t,e[5]*=t,e[9]*=t,e[13]*=t,e[2]*=t,e[6]*=t,e[10]*=t,e[14]*=t,e[3]*=t,e[7]*=t,e[11]*=t,e[15]*=t,this}determinant(){let t=this.elements,e=t[0],i=t[4],r=t[8],s=t[12],a=t[1],o=t[5],h=t[9],l=t[13],c=t[2],u=t[6],d=t[10],f=t[14],p=t[3],m=t[7],g=t[11],_=t[15],y=h*f-l*d,v=o*f-l*u,x=o*d-h*u,w=a*f-l*c,b=a*d-h*c,A=a*u-o*c;return e*(m*y-g*v+_*x)-i*(p*y-g*w+_*b)+r*(p*v-m*w+_*A)-s*(p*x-m*b+g*A)}determinantAffine(){let t=this.elements,e=t[0],i=t[4],r=t[8],s=t[1],a=t[5],o=t[9],h=t[2],l=t[6],c=t[10];return e*(a*c-o*l)-i*(s*c-o*h)+r*(s*l-a*h)}transpose(){let t=this.elements,e;return e=t[1],t[1]=t[4],t[4]=e,e=t[2],t[2]=t[8],t[8]=e,e=t[6],t[6]=t[9],t[9]=e,e=t[3],t[3]=t[12],t[12]=e,e=t[7],t[7]=t[13],t[13]=e,e=t[11],t[11]=t[14],t[14]=e,this}setPosition(t,e,i){let r=this.elements;return t.isVector3?(r[12]=t.x,r[13]=t.y,r[14]=t.z):(r[12]=t,r[13]=e,r[14]=i),this}invert(){let t=this.elements,e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8],u=t[9],d=t[10],f=t[11],p=t[12],m=t[13],g=t[14],_=t[15],y=e*o-i*a,v=e*h-r*a,x=e*l-s*a,w=i*h-r*o,b=i*l-s*o,A=r*l-s*h,I=c*m-u*p,C=c*g-d*p,P=c*_-f*p,L=u*g-d*m,G=u*_-f*m,q=d*_-f*g,V=y*q-v*G+x*L+w*P-b*C+A*I;if(V===0)return this.set(0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0);let B=1/V;return t[0]=(o*q-h*G+l*L)*B,t[1]=(r*G-i*q-s*L)*B,t[2]=(m*A-g*b+_*w)*B,t[3]=(d*b-u*A-f*w)*B,t[4]=(h*P-a*q-l*C)*B,t[5]=(e*q-r*P+s*C)*B,t[6]=(g*x-p*A-_*v)*B,t[7]=(c*A-d*x+f*v)*B,t[8]=(a*G-o*P+l*I)*B,t[9]=(i*P-e*G-s*I)*B,t[10]=(p*b-m*x+_*y)*B,t[11]=(u*x-c*b-f*y)*B,t[12]=(o*C-a*L-h*I)*B,t[13]=(e*L-i*C+r*I)*B,t[14]=(m*v-p*w-g*y)*B,t[15]=(c*w-u*v+d*y)*B,this}scale(t){let e=this.elements,i=t.x,r=t.y,s=t.z;return e[0]*=i,e[4]*=r,e[8]*=s,e[1]*=i,e[5]*=r,e[9]*=s,e[2]*=i,e[6]*=r,e[10]*=s,e[3]*=i,e[7]*=r,e[11]*=s,this}getMaxScaleOnAxis(){let t=this.elements,e=t[0]*t[0]+t[1]*t[1]+t[2]*t[2],i=t[4]*t[4]+t[5]*t[5]+t[6]*t[6],r=t[8]*t[8]+t[9]*t[9]+t[10]*t[10];return Math.sqrt(Math.max(e,i,r))}makeTranslation(t,e,i){return t.isVector3?this.set(1,0,0,t.x,0,1,0,t.y,0,0,1,t.z,0,0,0,1):this.set(1,0,0,t,0,1,0,e,0,0,1,i,0,0,0,1),this}makeRotationX(t){let e=Math.cos(t),i=Math.sin(t);return this.set(1,0,0,0,0,e,-i,0,0,i,e,0,0,0,0,1),this}makeRotationY(t){let e=Math.cos(t),i=Math.sin(t);return this.set(e,0,i,0,0,1,0,0,-i,0,e,0,0,0,0,1),this}makeRotationZ(t){let e=Math.cos(t),i=Math.sin(t);return this.set(e,-i,0,0,i,e,0,0,0,0,1,0,0,0,0,1),this}makeRotationAxis(t,e){let i=Math.cos(e),r=Math.sin(e),s=1-i,a=t.x,o=t.y,h=t.z,l=s*a,c=s*o;return this.set(l*a+i,l*o-r*h,l*h+r*o,0,l*o+r*h,c*o+i,c*h-r*a,0,l*h-r*o,c*h+r*a,s*h*h+i,0,0,0,0,1),this}makeScale(t,e,i){return this.set(t,0,0,0,0,e,0,0,0,0,i,0,0,0,0,1),this}makeShear(t,e,i,r,s,a){return this.set(1,i,s,0,t,1,a,0,e,r,1,0,0,0,0,1),this}compose(t,e,i){let r=this.elements,s=e._x,a=e._y,o=e._z,h=e._w,l=s+s,c=a+a,u=o+o,d=s*l,f=s*c,p=s*u,m=a*c,g=a*u,_=o*u,y=h*l,v=h*c,x=h*u,w=i.x,b=i.y,A=i.z;return r[0]=(1-(m+_))*w,r[1]=(f+x)*w,r[2]=(p-v)*w,r[3]=0,r[4]=(f-x)*b,r[5]=(1-(d+_))*b,r[6]=(g+y)*b,r[7]=0,r[8]=(p+v)*A,r[9]=(g-y)*A,r[10]=(1-(d+m))*A,r[11]=0,r[12]=t.x,r[13]=t.y,r[14]=t.z,r[15]=1,this}decompose(t,e,i){let r=this.elements;t.x=r[12],t.y=r[13],t.z=r[14];let s=this.determinantAffine();if(s===0)return i.set(1,1,1),e.identity(),this;let a=Kn.set(r[0],r[1],r[2]).length(),o=Kn.set(r[4],r[5],r[6]).length(),h=Kn.set(r[8],r[9],r[10]).length();s<0&&(a=-a),we.copy(this);let l=1/a,c=1/o,u=1/h;return we.elements[0]*=l,we.elements[1]*=l,we.elements[2]*=l,we.elements[4]*=c,we.elements[5]*=c,we.elements[6]*=c,we.elements[8]*=u,we.elements[9]*=u,we.elements[10]*=u,e.setFromRotationMatrix(we),i.x=a,i.y=o,i.z=h,this}makePerspective(t,e,i,r,s,a,o=Ui,h=!1){let l=this.elements,c=2*s/(e-t),u=2*s/(i-r),d=(e+t)/(e-t),f=(i+r)/(i-r),p,m;if(h)p=s/(a-s),m=a*s/(a-s);else if(o===Ui)p=-(a+s)/(a-s),m=-2*a*s/(a-s);else if(o===Nl)p=-a/(a-s),m=-a*s/(a-s);else throw new Error("THREE.Matrix4.makePerspective(): Invalid coordinate system: "+o);return l[0]=c,l[4]=0,l[8]=d,l[12]=0,l[1]=0,l[5]=u,l[9]=f,l[13]=0,l[2]=0,l[6]=0,l[10]=p,l[14]=m,l[3]=0,l[7]=0,l[11]=-1,l[15]=0,this}makeOrthographic(t,e,i,r,s,a,o=Ui,h=!1){let l=this.elements,c=2/(e-t),u=2/(i-r),d=-(e+t)/(e-t),f=-(i+r)/(i-r),p,m;if(h)p=1/(a-s),m=a/(a-s);else if(o===Ui)p=-2/(a-s),m=-(a+s)/(a-s);else if(o===Nl)p=-1/(a-s),m=-s/(a-s);else throw new Error("THREE.Matrix4.makeOrthographic(): Invalid coordinate system: "+o);return l[0]=c,l[4]=0,l[8]=0,l[12]=d,l[1]=0,l[5]=u,l[9]=0,l[13]=f,l[2]=0,l[6]=0,l[10]=p,l[14]=m,l[3]=0,l[7]=0,l[11]=0,l[15]=1,this}equals(t){let e=this.elements,i=t.elements;for(let r=0;r<16;r++)if(e[r]!==i[r])return!1;return!0}fromArray(t,e=0){for(let i=0;i<16;i++)this.elements[i]=t[i+e];return this}toArray(t=[],e=0){let i=this.elements;return t[e]=i[0],t[e+1]=i[1],t[e+2]=i[2],t[e+3]=i[3],t[e+4]=i[4],t[e+5]=i[5],t[e+6]=i[6],t[e+7]=i[7],t[e+8]=i[8],t[e+9]=i[9],t[e+10]=i[10],t[e+11]=i[11],t[e+12]=i[12],t[e+13]=i[13],t[e+14]=i[14],t[e+15]=i[15],t}},Kn=new Mt,we=new Ye,Nf=new Mt(0,0,0),Lf=new Mt(1,1,1),nn=new Mt,Pr=new Mt,se=new Mt,Ol=new Ye,Bl=new sn,zr=class n{constructor(t=0,e=0,i=0,r=n.DEFAULT_ORDER){this.isEuler=!0,this._x=t,this._y=e,this._z=i,this._order=r}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get order(){return this._order}set order(t){this._order=t,this._onChangeCallback()}set(t,e,i,r=this._order){return this._x=t,this._y=e,this._z=i,this._order=r,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._order)}copy(t){return this._x=t._x,this._y=t._y,this._z=t._z,this._order=t._order,this._onChangeCallback(),this}setFromRotationMatrix(t,e=this._order,i=!0){let r=t.elements,s=r[0],a=r[4],o=r[8],h=r[1],l=r[5],c=r[9],u=r[2],d=r[6],f=r[10];switch(e){case"XYZ":this._y=Math.asin(rt(o,-1,1)),Math.abs(o)<.9999999?(this._x=Math.atan2(-c,f),this._z=Math.atan2(-a,s)):(this._x=Math.atan2(d,l),this._z=0);break;case"YXZ":this._x=Math.asin(-rt(c,-1,1)),Math.abs(c)<.9999999?(this._y=Math.atan2(o,f),this._z=Math.atan2(h,l)):(this._y=Math.atan2(-u,s),this._z=0);break;case"ZXY":this._x=Math.asin(rt(d,-1,1)),Math.abs(d)<.9999999?(this._y=Math.atan2(-u,f),this._z=Math.atan2(-a,l)):(this._y=0,this._z=Math.atan2(h,s));break;case"ZYX":this._y=Math.asin(-rt(u,-1,1)),Math.abs(u)<.9999999?(this._x=Math.atan2(d,f),this._z=Math.atan2(h,s)):(this._x=0,this._z=Math.atan2(-a,l));break;case"YZX":this._z=Math.asin(rt(h,-1,1)),Math.abs(h)<.9999999?(this._x=Math.atan2(-c,l),this._y=Math.atan2(-u,s)):(this._x=0,this._y=Math.atan2(o,f));break;case"XZY":this._z=Math.asin(-rt(a,-1,1)),Math.abs(a)<.9999999?(this._x=Math.atan2(d,l),this._y=Math.atan2(o,s)):(this._x=Math.atan2(-c,f),this._y=0);break;default:$t("Euler: .setFromRotationMatrix() encountered an unknown order: "+e)}return this._order=e,i===!0&&this._onChangeCallback(),this}setFromQuaternion(t,e,i){return Ol.makeRotationFromQuaternion(t),this.setFromRotationMatrix(Ol,e,i)}setFromVector3(t,e=this._order){return this.set(t.x,t.y,t.z,e)}reorder(t){return Bl.setFromEuler(this),this.setFromQuaternion(Bl,t)}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._order===this._order}fromArray(t){return this._x=t[0],this._y=t[1],this._z=t[2],t[3]!==void 0&&(this._order=t[3]),this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._order,t}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._order}};zr.DEFAULT_ORDER="XYZ";var kr=class{constructor(){this.mask=1}set(t){this.mask=(1<<t|0)>>>0}enable(t){this.mask|=1<<t|0}enableAll(){this.mask=-1}toggle(t){this.mask^=1<<t|0}disable(t){this.mask&=~(1<<t|0)}disableAll(){this.mask=0}test(t){return(this.mask&t.mask)!==0}isEnabled(t){return(this.mask&(1<<t|0))!==0}},Df=0,zl=new Mt,Qn=new sn,Xe=new Ye,Nr=new Mt,Li=new Mt,Uf=new Mt,Ff=new sn,kl=new Mt(1,0,0),Gl=new Mt(0,1,0),Vl=new Mt(0,0,1),Hl={type:"added"},Of={type:"removed"},jn={type:"childadded",child:null},ca={type:"childremoved",child:null},Oi=class n extends Fi{constructor(){super(),this.isObject3D=!0,Object.defineProperty(this,"id",{value:Df++}),this.uuid=Ya(),this.name="",this.type="Object3D",this.parent=null,this.children=[],this.up=n.DEFAULT_UP.clone();let t=new Mt,e=new zr,i=new sn,r=new Mt(1,1,1);function s(){i.setFromEuler(e,!1)}function a(){e.setFromQuaternion(i,void 0,!1)}e._onChange(s),i._onChange(a),Object.defineProperties(this,{position:{configurable:!0,enumerable:!0,value:t},rotation:{configurable:!0,enumerable:!0,value:e},quaternion:{configurable:!0,enumerable:!0,value:i},scale:{configurable:!0,enumerable:!0,value:r},modelViewMatrix:{value:new Ye},normalMatrix:{value:new $}}),this.matrix=new Ye,this.matrixWorld=new Ye,this.matrixAutoUpdate=n.DEFAULT_MATRIX_AUTO_UPDATE,this.matrixWorldAutoUpdate=n.DEFAULT_MATRIX_WORLD_AUTO_UPDATE,this.matrixWorldNeedsUpdate=!1,this.layers=new kr,this.visible=!0,this.castShadow=!1,this.receiveShadow=!1,this.frustumCulled=!0,this.renderOrder=0,this.animations=[],this.customDepthMaterial=void 0,this.customDistanceMaterial=void 0,this.static=!1,this.userData={},this.pivot=null}onBeforeShadow(){}onAfterShadow(){}onBeforeRender(){}onAfterRender(){}applyMatrix4(t){this.matrixAutoUpdate&&this.updateMatrix(),this.matrix.premultiply(t),this.matrix.decompose(this.position,this.quaternion,this.scale),this.pivot!==null&&this.position.copy(this.pivot).applyMatrix4(this.matrix).sub(this.pivot)}applyQuaternion(t){return this.quaternion.premultiply(t),this}setRotationFromAxisAngle(t,e){this.quaternion.setFromAxisAngle(t,e)}setRotationFromEuler(t){this.quaternion.setFromEuler(t,!0)}setRotationFromMatrix(t){this.quaternion.setFromRotationMatrix(t)}setRotationFromQuaternion(t){this.quaternion.copy(t)}rotateOnAxis(t,e){return Qn.setFromAxisAngle(t,e),this.quaternion.multiply(Qn),this}rotateOnWorldAxis(t,e){return Qn.setFromAxisAngle(t,e),this.quaternion.premultiply(Qn),this}rotateX(t){return this.rotateOnAxis(kl,t)}rotateY(t){return this.rotateOnAxis(Gl,t)}rotateZ(t){return this.rotateOnAxis(Vl,t)}translateOnAxis(t,e){return zl.copy(t).applyQuaternion(this.quaternion),this.position.add(zl.multiplyScalar(e)),this}translateX(t){return this.translateOnAxis(kl,t)}translateY(t){return this.translateOnAxis(Gl,t)}translateZ(t){return this.translateOnAxis(Vl,t)}localToWorld(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(this.matrixWorld)}worldToLocal(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(Xe.copy(this.matrixWorld).invert())}lookAt(t,e,i){t.isVector3?Nr.copy(t):Nr.set(t,e,i);let r=this.parent;this.updateWorldMatrix(!0,!1),Li.setFromMatrixPosition(this.matrixWorld),this.isCamera||this.isLight?Xe.lookAt(Li,Nr,this.up):Xe.lookAt(Nr,Li,this.up),this.quaternion.setFromRotationMatrix(Xe),r&&(Xe.extractRotation(r.matrixWorld),Qn.setFromRotationMatrix(Xe),this.quaternion.premultiply(Qn.invert()))}add(t){if(arguments.length>1){for(let e=0;e<arguments.length;e++)this.add(arguments[e]);return this}return t===this?(Lt("Object3D.add: object can't be added as a child of itself.",t),this):(t&&t.isObject3D?(t.removeFromParent(),t.parent=this,this.children.push(t),t.dispatchEvent(Hl),jn.child=t,this.dispatchEvent(jn),jn.child=null):Lt("Object3D.add: object not an instance of THREE.Object3D.",t),this)}remove(t){if(arguments.length>1){for(let i=0;i<arguments.length;i++)this.remove(arguments[i]);return this}let e=this.children.indexOf(t);return e!==-1&&(t.parent=null,this.children.splice(e,1),t.dispatchEvent(Of),ca.child=t,this.dispatchEvent(ca),ca.child=null),this}removeFromParent(){let t=this.parent;return t!==null&&t.remove(this),this}clear(){return this.remove(...this.children)}attach(t){return this.updateWorldMatrix(!0,!1),Xe.copy(this.matrixWorld).invert(),t.parent!==null&&(t.parent.updateWorldMatrix(!0,!1),Xe.multiply(t.parent.matrixWorld)),t.applyMatrix4(Xe),t.removeFromParent(),t.parent=this,this.children.push(t),t.updateWorldMatrix(!1,!0),t.dispatchEvent(Hl),jn.child=t,this.dispatchEvent(jn),jn.child=null,this}getObjectById(t){return this.getObjectByProperty("id",t)}getObjectByName(t){return this.getObjectByProperty("name",t)}getObjectByProperty(t,e){if(this[t]===e)return this;for(let i=0,r=this.children.length;i<r;i++){let a=this.children[i].getObjectByProperty(t,e);if(a!==void 0)return a}}getObjectsByProperty(t,e,i=[]){this[t]===e&&i.push(this);let r=this.children;for(let s=0,a=r.length;s<a;s++)r[s].getObjectsByProperty(t,e,i);return i}getWorldPosition(t){return this.updateWorldMatrix(!0,!1),t.setFromMatrixPosition(this.matrixWorld)}getWorldQuaternion(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(Li,t,Uf),t}getWorldScale(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(Li,Ff,t),t}getWorldDirection(t){this.updateWorldMatrix(!0,!1);let e=this.matrixWorld.elements;return t.set(e[8],e[9],e[10]).normalize()}raycast(){}intersectsFrustum(){return!0}traverse(t){t(this);let e=this.children;for(let i=0,r=e.length;i<r;i++)e[i].traverse(t)}traverseVisible(t){if(this.visible===!1)return;t(this);let e=this.children;for(let i=0,r=e.length;i<r;i++)e[i].traverseVisible(t)}traverseAncestors(t){let e=this.parent;e!==null&&(t(e),e.traverseAncestors(t))}updateMatrix(){this.matrix.compose(this.position,this.quaternion,this.scale);let t=this.pivot;if(t!==null){let e=t.x,i=t.y,r=t.z,s=this.matrix.elements;s[12]+=e-s[0]*e-s[4]*i-s[8]*r,s[13]+=i-s[1]*e-s[5]*i-s[9]*r,s[14]+=r-s[2]*e-s[6]*i-s[10]*r}this.matrixWorldNeedsUpdate=!0}updateMatrixWorld(t){this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||t)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,t=!0);let e=this.children;for(let i=0,r=e.length;i<r;i++)e[i].updateMatrixWorld(t)}updateWorldMatrix(t,e,i=!1){let r=this.parent;if(t===!0&&r!==null&&r.updateWorldMatrix(!0,!1),this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||i)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,i=!0),e===!0){let s=this.children;for(let a=0,o=s.length;a<o;a++)s[a].updateWorldMatrix(!1,!0,i)}}toJSON(t){let e=t===void 0||typeof t=="string",i={};e&&(t={geometries:{},materials:{},textures:{},images:{},shapes:{},skeletons:{},animations:{},nodes:{}},i.metadata={version:4.7,type:"Object",generator:"Object3D.toJSON"});let r={};r.uuid=this.uuid,r.type=this.type,r.name=this.name,r.castShadow=this.castShadow,r.receiveShadow=this.receiveShadow,r.visible=this.visible,r.frustumCulled=this.frustumCulled,r.renderOrder=this.renderOrder,r.static=this.static,r.matrixAutoUpdate=this.matrixAutoUpdate,Object.keys(this.userData).length>0&&(r.userData=this.userData),r.layers=this.layers.mask,r.matrix=this.matrix.toArray(),r.up=this.up.toArray(),this.pivot!==null&&(r.pivot=this.pivot.toArray()),this.morphTargetDictionary!==void 0&&(r.morphTargetDictionary=Object.assign({},this.morphTargetDictionary)),this.morphTargetInfluences!==void 0&&(r.morphTargetInfluences=this.morphTargetInfluences.slice()),this.isInstancedMesh&&(r.type="InstancedMesh",r.count=this.count,r.instanceMatrix=this.instanceMatrix.toJSON(),this.instanceColor!==null&&(r.instanceColor=this.instanceColor.toJSON())),this.isBatchedMesh&&(r.type="BatchedMesh",r.perObjectFrustumCulled=this.perObjectFrustumCulled,r.sortObjects=this.sortObjects,r.drawRanges=this._drawRanges,r.reservedRanges=this._reservedRanges,r.geometryInfo=this._geometryInfo.map(o=>({...o,boundingBox:o.boundingBox?o.boundingBox.toJSON():void 0,boundingSphere:o.boundingSphere?o.boundingSphere.toJSON():void 0})),r.instanceInfo=this._instanceInfo.map(o=>({...o})),r.availableInstanceIds=this._availableInstanceIds.slice(),r.availableGeometryIds=this._availableGeometryIds.slice(),r.nextIndexStart=this._nextIndexStart,r.nextVertexStart=this._nextVertexStart,r.geometryCount=this._geometryCount,r.maxInstanceCount=this._maxInstanceCount,r.maxVertexCount=this._maxVertexCount,r.maxIndexCount=this._maxIndexCount,r.geometryInitialized=this._geometryInitialized,r.matricesTexture=this._matricesTexture.toJSON(t),r.indirectTexture=this._indirectTexture.toJSON(t),this._colorsTexture!==null&&(r.colorsTexture=this._colorsTexture.toJSON(t)),this.boundingSphere!==null&&(r.boundingSphere=this.boundingSphere.toJSON()),this.boundingBox!==null&&(r.boundingBox=this.boundingBox.toJSON()));function s(o,h){return o[h.uuid]===void 0&&(o[h.uuid]=h.toJSON(t)),h.uuid}if(this.isScene)this.background&&(this.background.isColor?r.background=this.background.toJSON():this.background.isTexture&&(r.background=this.background.toJSON(t).uuid)),this.environment&&this.environment.isTexture&&this.environment.isRenderTargetTexture!==!0&&(r.environment=this.environment.toJSON(t).uuid);else if(this.isMesh||this.isLine||this.isPoints){r.geometry=s(t.geometries,this.geometry);let o=this.geometry.parameters;if(o!==void 0&&o.shapes!==void 0){let h=o.shapes;if(Array.isArray(h))for(let l=0,c=h.length;l<c;l++){let u=h[l];s(t.shapes,u)}else s(t.shapes,h)}}if(this.isSkinnedMesh&&(r.bindMode=this.bindMode,r.bindMatrix=this.bindMatrix.toArray(),this.skeleton!==void 0&&(s(t.skeletons,this.skeleton),r.skeleton=this.skeleton.uuid)),this.material!==void 0)if(Array.isArray(this.material)){let o=[];for(let h=0,l=this.material.length;h<l;h++)o.push(s(t.materials,this.material[h]));r.material=o}else r.material=s(t.materials,this.material);if(this.children.length>0){r.children=[];for(let o=0;o<this.children.length;o++)r.children.push(this.children[o].toJSON(t).object)}if(this.animations.length>0){r.animations=[];for(let o=0;o<this.animations.length;o++){let h=this.animations[o];r.animations.push(s(t.animations,h))}}if(e){let o=a(t.geometries),h=a(t.materials),l=a(t.textures),c=a(t.images),u=a(t.shapes),d=a(t.skeletons),f=a(t.animations),p=a(t.nodes);o.length>0&&(i.geometries=o),h.length>0&&(i.materials=h),l.length>0&&(i.textures=l),c.length>0&&(i.images=c),u.length>0&&(i.shapes=u),d.length>0&&(i.skeletons=d),f.length>0&&(i.animations=f),p.length>0&&(i.nodes=p)}return i.object=r,i;function a(o){let h=[];for(let l in o){let c=o[l];delete c.metadata,h.push(c)}return h}}clone(t){return new this.constructor().copy(this,t)}copy(t,e=!0){if(this.name=t.name,this.up.copy(t.up),this.position.copy(t.position),this.rotation.order=t.rotation.order,this.quaternion.copy(t.quaternion),this.scale.copy(t.scale),this.pivot=t.pivot!==null?t.pivot.clone():null,this.matrix.copy(t.matrix),this.matrixWorld.copy(t.matrixWorld),this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrixWorldAutoUpdate=t.matrixWorldAutoUpdate,this.matrixWorldNeedsUpdate=t.matrixWorldNeedsUpdate,this.layers.mask=t.layers.mask,this.visible=t.visible,this.castShadow=t.castShadow,this.receiveShadow=t.receiveShadow,this.frustumCulled=t.frustumCulled,this.renderOrder=t.renderOrder,this.static=t.static,this.animations=t.animations.slice(),this.userData=JSON.parse(JSON.stringify(t.userData)),e===!0)for(let i=0;i<t.children.length;i++){let r=t.children[i];this.add(r.clone())}return this}dispose(){this.dispatchEvent({type:"dispose"})}};Oi.DEFAULT_UP=new Mt(0,1,0);Oi.DEFAULT_MATRIX_AUTO_UPDATE=!0;Oi.DEFAULT_MATRIX_WORLD_AUTO_UPDATE=!0;var ac={aliceblue:15792383,antiquewhite:16444375,aqua:65535,aquamarine:8388564,azure:15794175,beige:16119260,bisque:16770244,black:0,blanchedalmond:16772045,blue:255,blueviolet:9055202,brown:10824234,burlywood:14596231,cadetblue:6266528,chartreuse:8388352,chocolate:13789470,coral:16744272,cornflowerblue:6591981,cornsilk:16775388,crimson:14423100,cyan:65535,darkblue:139,darkcyan:35723,darkgoldenrod:12092939,darkgray:11119017,darkgreen:25600,darkgrey:11119017,darkkhaki:12433259,darkmagenta:9109643,darkolivegreen:5597999,darkorange:16747520,darkorchid:10040012,darkred:9109504,darksalmon:15308410,darkseagreen:9419919,darkslateblue:4734347,darkslategray:3100495,darkslategrey:3100495,darkturquoise:52945,darkviolet:9699539,deeppink:16716947,deepskyblue:49151,dimgray:6908265,dimgrey:6908265,dodgerblue:2003199,firebrick:11674146,floralwhite:16775920,forestgreen:2263842,fuchsia:16711935,gainsboro:14474460,ghostwhite:16316671,gold:16766720,goldenrod:14329120,gray:8421504,green:32768,greenyellow:11403055,grey:8421504,honeydew:15794160,hotpink:16738740,indianred:13458524,indigo:4915330,ivory:16777200,khaki:15787660,lavender:15132410,lavenderblush:16773365,lawngreen:8190976,lemonchiffon:16775885,lightblue:11393254,lightcoral:15761536,lightcyan:14745599,lightgoldenrodyellow:16448210,lightgray:13882323,lightgreen:9498256,lightgrey:13882323,lightpink:16758465,lightsalmon:16752762,lightseagreen:2142890,lightskyblue:8900346,lightslategray:7833753,lightslategrey:7833753,lightsteelblue:11584734,lightyellow:16777184,lime:65280,limegreen:3329330,linen:16445670,magenta:16711935,maroon:8388608,mediumaquamarine:6737322,mediumblue:205,mediumorchid:12211667,mediumpurple:9662683,mediumseagreen:3978097,mediumslateblue:8087790,mediumspringgreen:64154,mediumturquoise:4772300,mediumvioletred:13047173,midnightblue:1644912,mintcream:16121850,mistyrose:16770273,moccasin:16770229,navajowhite:16768685,navy:128,oldlace:16643558,olive:8421376,olivedrab:7048739,orange:16753920,orangered:16729344,orchid:14315734,palegoldenrod:15657130,palegreen:10025880,paleturquoise:11529966,palevioletred:14381203,papayawhip:16773077,peachpuff:16767673,peru:13468991,pink:16761035,plum:14524637,powderblue:11591910,purple:8388736,rebeccapurple:6697881,red:16711680,rosybrown:12357519,royalblue:4286945,saddlebrown:9127187,salmon:16416882,sandybrown:16032864,seagreen:3050327,seashell:16774638,sienna:10506797,silver:12632256,skyblue:8900331,slateblue:6970061,slategray:7372944,slategrey:7372944,snow:16775930,springgreen:65407,steelblue:4620980,tan:13808780,teal:32896,thistle:14204888,tomato:16737095,turquoise:4251856,violet:15631086,wheat:16113331,white:16777215,whitesmoke:16119285,yellow:16776960,yellowgreen:10145074},rn={h:0,s:0,l:0},Lr={h:0,s:0,l:0};function ha(n,t,e){return e<0&&(e+=1),e>1&&(e-=1),e<1/6?n+(t-n)*6*e:e<1/2?t:e<2/3?n+(t-n)*6*(2/3-e):n}var Dt=class{constructor(t,e,i){return this.isColor=!0,this.r=1,this.g=1,this.b=1,this.set(t,e,i)}set(t,e,i){if(e===void 0&&i===void 0){let r=t;r&&r.isColor?this.copy(r):typeof r=="number"?this.setHex(r):typeof r=="string"&&this.setStyle(r)}else this.setRGB(t,e,i);return this}setScalar(t){return this.r=t,this.g=t,this.b=t,this}setHex(t,e=de){return t=Math.floor(t),this.r=(t>>16&255)/255,this.g=(t>>8&255)/255,this.b=(t&255)/255,fe.colorSpaceToWorking(this,e),this}setRGB(t,e,i,r=fe.workingColorSpace){return this.r=t,this.g=e,this.b=i,fe.colorSpaceToWorking(this,r),this}setHSL(t,e,i,r=fe.workingColorSpace){if(t=Rf(t,1),e=rt(e,0,1),i=rt(i,0,1),e===0)this.r=this.g=this.b=i;else{let s=i<=.5?i*(1+e):i+e-i*e,a=2*i-s;this.r=ha(a,s,t+1/3),this.g=ha(a,s,t),this.b=ha(a,s,t-1/3)}return fe.colorSpaceToWorking(this,r),this}setStyle(t,e=de){function i(s){s!==void 0&&parseFloat(s)<1&&$t("Color: Alpha component of "+t+" will be ignored.")}let r;if(r=/^(\w+)\(([^\)]*)\)/.exec(t)){let s,a=r[1],o=r[2];switch(a){case"rgb":case"rgba":if(s=/^\s*(\d+)\s*,\s*(\d+)\s*,\s*(\d+)\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(o))return i(s[4]),this.setRGB(Math.min(255,parseInt(s[1],10))/255,Math.min(255,parseInt(s[2],10))/255,Math.min(255,parseInt(s[3],10))/255,e);if(s=/^\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(o))return i(s[4]),this.setRGB(Math.min(100,parseFloat(s[1]))/100,Math.min(100,parseFloat(s[2]))/100,Math.min(100,parseFloat(s[3]))/100,e);break;case"hsl":case"hsla":if(s=/^\s*([+-]?(?:\d+(?:\.\d+)?|\.\d+))\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(o))return i(s[4]),this.setHSL(parseFloat(s[1])/360,parseFloat(s[2])/100,parseFloat(s[3])/100,e);break;default:$t("Color: Unknown color model "+t)}}else if(r=/^\#([A-Fa-f\d]+)$/.exec(t)){let s=r[1],a=s.length;if(a===3)return this.setRGB(parseInt(s.charAt(0),16)/15,parseInt(s.charAt(1),16)/15,parseInt(s.charAt(2),16)/15,e);if(a===6)return this.setHex(parseInt(s,16),e);$t("Color: Invalid hex color "+t)}else if(t&&t.length>0)return this.setColorName(t,e);return this}setColorName(t,e=de){let i=ac[t.toLowerCase()];return i!==void 0?this.setHex(i,e):$t("Color: Unknown color "+t),this}clone(){return new this.constructor(this.r,this.g,this.b)}copy(t){return this.r=t.r,this.g=t.g,this.b=t.b,this}copySRGBToLinear(t){return this.r=qe(t.r),this.g=qe(t.g),this.b=qe(t.b),this}copyLinearToSRGB(t){return this.r=ei(t.r),this.g=ei(t.g),this.b=ei(t.b),this}convertSRGBToLinear(){return this.copySRGBToLinear(this),this}convertLinearToSRGB(){return this.copyLinearToSRGB(this),this}getHex(t=de){return fe.workingToColorSpace(Jt.copy(this),t),Math.round(rt(Jt.r*255,0,255))*65536+Math.round(rt(Jt.g*255,0,255))*256+Math.round(rt(Jt.b*255,0,255))}getHexString(t=de){return("000000"+this.getHex(t).toString(16)).slice(-6)}getHSL(t,e=fe.workingColorSpace){fe.workingToColorSpace(Jt.copy(this),e);let i=Jt.r,r=Jt.g,s=Jt.b,a=Math.max(i,r,s),o=Math.min(i,r,s),h,l,c=(o+a)/2;if(o===a)h=0,l=0;else{let u=a-o;switch(l=c<=.5?u/(a+o):u/(2-a-o),a){case i:h=(r-s)/u+(r<s?6:0);break;case r:h=(s-i)/u+2;break;case s:h=(i-r)/u+4;break}h/=6}return t.h=h,t.s=l,t.l=c,t}getRGB(t,e=fe.workingColorSpace){return fe.workingToColorSpace(Jt.copy(this),e),t.r=Jt.r,t.g=Jt.g,t.b=Jt.b,t}getStyle(t=de){fe.workingToColorSpace(Jt.copy(this),t);let e=Jt.r,i=Jt.g,r=Jt.b;return t!==de?`color(${t} ${e.toFixed(3)} ${i.toFixed(3)} ${r.toFixed(3)})`:`rgb(${Math.round(e*255)},${Math.round(i*255)},${Math.round(r*255)})`}offsetHSL(t,e,i){return this.getHSL(rn),this.setHSL(rn.h+t,rn.s+e,rn.l+i)}add(t){return this.r+=t.r,this.g+=t.g,this.b+=t.b,this}addColors(t,e){return this.r=t.r+e.r,this.g=t.g+e.g,this.b=t.b+e.b,this}addScalar(t){return this.r+=t,this.g+=t,this.b+=t,this}sub(t){return this.r=Math.max(0,this.r-t.r),this.g=Math.max(0,this.g-t.g),this.b=Math.max(0,this.b-t.b),this}multiply(t){return this.r*=t.r,this.g*=t.g,this.b*=t.b,this}multiplyScalar(t){return this.r*=t,this.g*=t,this.b*=t,this}lerp(t,e){return this.r+=(t.r-this.r)*e,this.g+=(t.g-this.g)*e,this.b+=(t.b-this.b)*e,this}lerpColors(t,e,i){return this.r=t.r+(e.r-t.r)*i,this.g=t.g+(e.g-t.g)*i,this.b=t.b+(e.b-t.b)*i,this}lerpHSL(t,e){this.getHSL(rn),t.getHSL(Lr);let i=ra(rn.h,Lr.h,e),r=ra(rn.s,Lr.s,e),s=ra(rn.l,Lr.l,e);return this.setHSL(i,r,s),this}setFromVector3(t){return this.r=t.x,this.g=t.y,this.b=t.z,this}applyMatrix3(t){let e=this.r,i=this.g,r=this.b,s=t.elements;return this.r=s[0]*e+s[3]*i+s[6]*r,this.g=s[1]*e+s[4]*i+s[7]*r,this.b=s[2]*e+s[5]*i+s[8]*r,this}equals(t){return t.r===this.r&&t.g===this.g&&t.b===this.b}fromArray(t,e=0){return this.r=t[e],this.g=t[e+1],this.b=t[e+2],this}toArray(t=[],e=0){return t[e]=this.r,t[e+1]=this.g,t[e+2]=this.b,t}fromBufferAttribute(t,e){return this.r=t.getX(e),this.g=t.getY(e),this.b=t.getZ(e),this}toJSON(){return this.getHex()}*[Symbol.iterator](){yield this.r,yield this.g,yield this.b}},Jt=new Dt;Dt.NAMES=ac;function oc(n){let t={};for(let e in n){t[e]={};for(let i in n[e]){let r=n[e][i];if(Wl(r))r.isRenderTargetTexture?($t("UniformsUtils: Textures of render targets cannot be cloned via cloneUniforms() or mergeUniforms()."),t[e][i]=null):t[e][i]=r.clone();else if(Array.isArray(r))if(Wl(r[0])){let s=[];for(let a=0,o=r.length;a<o;a++)s[a]=r[a].clone();t[e][i]=s}else t[e][i]=r.slice();else t[e][i]=r}}return t}function te(n){let t={};for(let e=0;e<n.length;e++){let i=oc(n[e]);for(let r in i)t[r]=i[r]}return t}function Wl(n){return n&&(n.isColor||n.isMatrix3||n.isMatrix4||n.isVector2||n.isVector3||n.isVector4||n.isTexture||n.isQuaternion)}function ti(n,t){return!n||n.constructor===t?n:typeof t.BYTES_PER_ELEMENT=="number"?new t(n):Array.prototype.slice.call(n)}function Dr(n){return n!==void 0&&n.inTangents!==void 0&&n.outTangents!==void 0}var Mn=class{constructor(t,e,i,r){this.parameterPositions=t,this._cachedIndex=0,this.resultBuffer=r!==void 0?r:new e.constructor(i),this.sampleValues=e,this.valueSize=i,this.settings=null,this.DefaultSettings_={}}evaluate(t){let e=this.parameterPositions,i=this._cachedIndex,r=e[i],s=e[i-1];t:{e:{let a;n:{i:if(!(t<r)){for(let o=i+2;;){if(r===void 0){if(t<s)break i;return i=e.length,this._cachedIndex=i,this.copySampleValue_(i-1)}if(i===o)break;if(s=r,r=e[++i],t<r)break e}a=e.length;break n}if(!(t>=s)){let o=e[1];t<o&&(i=2,s=o);for(let h=i-2;;){if(s===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(i===h)break;if(r=s,s=e[--i-1],t>=s)break e}a=i,i=0;break n}break t}for(;i<a;){let o=i+a>>>1;t<e[o]?a=o:i=o+1}if(r=e[i],s=e[i-1],s===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(r===void 0)return i=e.length,this._cachedIndex=i,this.copySampleValue_(i-1)}this._cachedIndex=i,this.intervalChanged_(i,s,r)}return this.interpolate_(i,s,t,r)}getSettings_(){return this.settings||this.DefaultSettings_}copySampleValue_(t){let e=this.resultBuffer,i=this.sampleValues,r=this.valueSize,s=t*r;for(let a=0;a!==r;++a)e[a]=i[s+a];return e}interpolate_(){throw new Error("THREE.Interpolant: Call to abstract method.")}intervalChanged_(){}},Ra=class extends Mn{constructor(t,e,i,r){super(t,e,i,r),this._weightPrev=-0,this._offsetPrev=-0,this._weightNext=-0,this._offsetNext=-0,this.DefaultSettings_={endingStart:Cl,endingEnd:Cl}}intervalChanged_(t,e,i){let r=this.parameterPositions,s=t-2,a=t+1,o=r[s],h=r[a];if(o===void 0)switch(this.getSettings_().endingStart){case Il:s=t,o=2*e-i;break;case Pl:s=r.length-2,o=e+r[s]-r[s+1];break;default:s=t,o=i}if(h===void 0)switch(this.getSettings_().endingEnd){case Il:a=t,h=2*i-e;break;case Pl:a=1,h=i+r[1]-r[0];break;default:a=t-1,h=e}let l=(i-e)*.5,c=this.valueSize;this._weightPrev=l/(e-o),this._weightNext=l/(h-i),this._offsetPrev=s*c,this._offsetNext=a*c}interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=t*o,l=h-o,c=this._offsetPrev,u=this._offsetNext,d=this._weightPrev,f=this._weightNext,p=(i-e)/(r-e),m=p*p,g=m*p,_=-d*g+2*d*m-d*p,y=(1+d)*g+(-1.5-2*d)*m+(-.5+d)*p+1,v=(-1-f)*g+(1.5+f)*m+.5*p,x=f*g-f*m;for(let w=0;w!==o;++w)s[w]=_*a[c+w]+y*a[l+w]+v*a[h+w]+x*a[u+w];return s}},Ca=class extends Mn{constructor(t,e,i,r){super(t,e,i,r)}interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=t*o,l=h-o,c=(i-e)/(r-e),u=1-c;for(let d=0;d!==o;++d)s[d]=a[l+d]*u+a[h+d]*c;return s}},Ia=class extends Mn{constructor(t,e,i,r){super(t,e,i,r)}interpolate_(t){return this.copySampleValue_(t-1)}},Pa=class extends Mn{interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=t*o,l=h-o,c=this.inTangents,u=this.outTangents;if(!c||!u){let p=(i-e)/(r-e),m=1-p;for(let g=0;g!==o;++g)s[g]=a[l+g]*m+a[h+g]*p;return s}let d=o*2,f=t-1;for(let p=0;p!==o;++p){let m=a[l+p],g=a[h+p],_=f*d+p*2,y=u[_],v=u[_+1],x=t*d+p*2,w=c[x],b=c[x+1],A=zf(i,e,y,w,r);s[p]=lc(A,m,v,b,g)}return s}};function lc(n,t,e,i,r){let s=1-n;return s*s*s*t+3*s*s*n*e+3*s*n*n*i+n*n*n*r}function Bf(n,t,e,i,r){let s=1-n;return 3*s*s*(e-t)+6*s*n*(i-e)+3*n*n*(r-i)}function zf(n,t,e,i,r){let s=(n-t)/(r-t);for(let a=0;a<8;a++){let o=lc(s,t,e,i,r)-n;if(Math.abs(o)<1e-10)break;let h=Bf(s,t,e,i,r);if(Math.abs(h)<1e-10)break;s=Math.max(0,Math.min(1,s-o/h))}return s}var pe=class{constructor(t,e,i,r){if(t===void 0)throw new Error("THREE.KeyframeTrack: track name is undefined");if(e===void 0||e.length===0)throw new Error("THREE.KeyframeTrack: no keyframes in track named "+t);this.name=t,this.times=ti(e,this.TimeBufferType),this.values=ti(i,this.ValueBufferType),this.setInterpolation(r||this.DefaultInterpolation)}static toJSON(t){let e=t.constructor,i;if(e.toJSON!==this.toJSON)i=e.toJSON(t);else{i={name:t.name,times:ti(t.times,Array),values:ti(t.values,Array)};let r=t.getInterpolation();r!==t.DefaultInterpolation&&(i.interpolation=r),Dr(t.settings)&&(i.settings={inTangents:ti(t.settings.inTangents,Array),outTangents:ti(t.settings.outTangents,Array)})}return i.type=t.ValueTypeName,i}InterpolantFactoryMethodDiscrete(t){return new Ia(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodLinear(t){return new Ca(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodSmooth(t){return new Ra(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodBezier(t){let e=new Pa(this.times,this.values,this.getValueSize(),t);return this.settings&&(e.inTangents=this.settings.inTangents,e.outTangents=this.settings.outTangents),e}setInterpolation(t){let e;switch(t){case Or:e=this.InterpolantFactoryMethodDiscrete;break;case Sa:e=this.InterpolantFactoryMethodLinear;break;case ia:e=this.InterpolantFactoryMethodSmooth;break;case Rl:e=this.InterpolantFactoryMethodBezier;break}if(e===void 0){let i="unsupported interpolation for "+this.ValueTypeName+" keyframe track named "+this.name;if(this.createInterpolant===void 0)if(t!==this.DefaultInterpolation)this.setInterpolation(this.DefaultInterpolation);else throw new Error(i);return $t("KeyframeTrack:",i),this}return this.createInterpolant=e,this}getInterpolation(){switch(this.createInterpolant){case this.InterpolantFactoryMethodDiscrete:return Or;case this.InterpolantFactoryMethodLinear:return Sa;case this.InterpolantFactoryMethodSmooth:return ia;case this.InterpolantFactoryMethodBezier:return Rl}}getValueSize(){return this.values.length/this.times.length}shift(t){if(t!==0){let e=this.times;for(let i=0,r=e.length;i!==r;++i)e[i]+=t;Dr(this.settings)&&(Xl(this.settings.inTangents,t),Xl(this.settings.outTangents,t))}return this}scale(t){if(t!==1){let e=this.times;for(let i=0,r=e.length;i!==r;++i)e[i]*=t;Dr(this.settings)&&(ql(this.settings.inTangents,t),ql(this.settings.outTangents,t))}return this}trim(t,e){let i=this.times,r=i.length,s=0,a=r-1;for(;s!==r&&i[s]<t;)++s;for(;a!==-1&&i[a]>e;)--a;if(++a,s!==0||a!==r){s>=a&&(a=Math.max(a,1),s=a-1);let o=this.getValueSize();this.times=i.slice(s,a),this.values=this.values.slice(s*o,a*o)}return this}validate(){let t=!0,e=this.getValueSize();e-Math.floor(e)!==0&&(Lt("KeyframeTrack: Invalid value size in track.",this),t=!1);let i=this.times,r=this.values,s=i.length;s===0&&(Lt("KeyframeTrack: Track is empty.",this),t=!1);let a=null;for(let o=0;o!==s;o++){let h=i[o];if(typeof h=="number"&&isNaN(h)){Lt("KeyframeTrack: Time is not a valid number.",this,o,h),t=!1;break}if(a!==null&&a>h){Lt("KeyframeTrack: Out of order keys.",this,o,h,a),t=!1;break}a=h}if(r!==void 0&&Ef(r))for(let o=0,h=r.length;o!==h;++o){let l=r[o];if(isNaN(l)){Lt("KeyframeTrack: Value is not a valid number.",this,o,l),t=!1;break}}return t}optimize(){let t=this.times.slice(),e=this.values.slice(),i=this.getValueSize(),r=this.getInterpolation()===ia,s=t.length-1,a=1;for(let o=1;o<s;++o){let h=!1,l=t[o],c=t[o+1];if(l!==c&&(o!==1||l!==t[0]))if(r)h=!0;else{let u=o*i,d=u-i,f=u+i;for(let p=0;p!==i;++p){let m=e[u+p];if(m!==e[d+p]||m!==e[f+p]){h=!0;break}}}if(h){if(o!==a){t[a]=t[o];let u=o*i,d=a*i;for(let f=0;f!==i;++f)e[d+f]=e[u+f]}++a}}if(s>0){t[a]=t[s];for(let o=s*i,h=a*i,l=0;l!==i;++l)e[h+l]=e[o+l];++a}return a!==t.length?(this.times=t.slice(0,a),this.values=e.slice(0,a*i)):(this.times=t,this.values=e),this}clone(){let t=this.times.slice(),e=this.values.slice(),i=this.constructor,r=new i(this.name,t,e);return r.createInterpolant=this.createInterpolant,Dr(this.settings)&&(r.settings={inTangents:this.settings.inTangents.slice(),outTangents:this.settings.outTangents.slice()}),r}};function Xl(n,t){for(let e=0,i=n.length;e!==i;e+=2)n[e]+=t}function ql(n,t){for(let e=0,i=n.length;e!==i;e+=2)n[e]*=t}pe.prototype.ValueTypeName="";pe.prototype.TimeBufferType=Float32Array;pe.prototype.ValueBufferType=Float32Array;pe.prototype.DefaultInterpolation=Sa;var bn=class extends pe{constructor(t,e,i){super(t,e,i)}};bn.prototype.ValueTypeName="bool";bn.prototype.ValueBufferType=Array;bn.prototype.DefaultInterpolation=Or;bn.prototype.InterpolantFactoryMethodLinear=void 0;bn.prototype.InterpolantFactoryMethodSmooth=void 0;var Na=class extends pe{constructor(t,e,i,r){super(t,e,i,r)}};Na.prototype.ValueTypeName="color";var La=class extends pe{constructor(t,e,i,r){super(t,e,i,r)}};La.prototype.ValueTypeName="number";var Da=class extends Mn{constructor(t,e,i,r){super(t,e,i,r)}interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=(i-e)/(r-e),l=t*o;for(let c=l+o;l!==c;l+=4)sn.slerpFlat(s,0,a,l-o,a,l,h);return s}},Gr=class extends pe{constructor(t,e,i,r){super(t,e,i,r)}InterpolantFactoryMethodLinear(t){return new Da(this.times,this.values,this.getValueSize(),t)}};Gr.prototype.ValueTypeName="quaternion";Gr.prototype.InterpolantFactoryMethodSmooth=void 0;var wn=class extends pe{constructor(t,e,i){super(t,e,i)}};wn.prototype.ValueTypeName="string";wn.prototype.ValueBufferType=Array;wn.prototype.DefaultInterpolation=Or;wn.prototype.InterpolantFactoryMethodLinear=void 0;wn.prototype.InterpolantFactoryMethodSmooth=void 0;var Ua=class extends pe{constructor(t,e,i,r){super(t,e,i,r)}};Ua.prototype.ValueTypeName="vector";var Fa=class{constructor(t,e,i){let r=this,s=!1,a=0,o=0,h,l=[];this.onStart=void 0,this.onLoad=t,this.onProgress=e,this.onError=i,this._abortController=null,this.itemStart=function(c){o++,s===!1&&r.onStart!==void 0&&r.onStart(c,a,o),s=!0},this.itemEnd=function(c){a++,r.onProgress!==void 0&&r.onProgress(c,a,o),a===o&&(s=!1,r.onLoad!==void 0&&r.onLoad())},this.itemError=function(c){r.onError!==void 0&&r.onError(c)},this.resolveURL=function(c){return c=c.normalize("NFC"),h?h(c):c},this.setURLModifier=function(c){return h=c,this},this.addHandler=function(c,u){return l.push(c,u),this},this.removeHandler=function(c){let u=l.indexOf(c);return u!==-1&&l.splice(u,2),this},this.getHandler=function(c){for(let u=0,d=l.length;u<d;u+=2){let f=l[u],p=l[u+1];if(f.global&&(f.lastIndex=0),f.test(c))return p}return null},this.abort=function(){return this.abortController.abort(),this._abortController=null,this}}get abortController(){return this._abortController||(this._abortController=new AbortController),this._abortController}},kf=new Fa,Oa=class{constructor(t){this.manager=t!==void 0?t:kf,this.crossOrigin="anonymous",this.withCredentials=!1,this.path="",this.resourcePath="",this.requestHeader={},this.priority="auto",this.cache="default",typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}load(){}loadAsync(t,e){let i=this;return new Promise(function(r,s){i.load(t,r,e,s)})}parse(){}setCrossOrigin(t){return this.crossOrigin=t,this}setWithCredentials(t){return this.withCredentials=t,this}setPath(t){return this.path=t,this}setResourcePath(t){return this.resourcePath=t,this}setRequestHeader(t){return this.requestHeader=t,this}setPriority(t){return this.priority=t,this}setCache(t){return this.cache=t,this}abort(){return this}};Oa.DEFAULT_MATERIAL_NAME="__DEFAULT";var Za="\\[\\]\\.:\\/",Gf=new RegExp("["+Za+"]","g"),Ja="[^"+Za+"]",Vf="[^"+Za.replace("\\.","")+"]",Hf=/((?:WC+[\/:])*)/.source.replace("WC",Ja),Wf=/(WCOD+)?/.source.replace("WCOD",Vf),Xf=/(?:\.(WC+)(?:\[(.+)\])?)?/.source.replace("WC",Ja),qf=/\.(WC+)(?:\[(.+)\])?/.source.replace("WC",Ja),Yf=new RegExp("^"+Hf+Wf+Xf+qf+"$"),Zf=["material","materials","bones","map"],Ba=class{constructor(t,e,i){let r=i||St.parseTrackName(e);this._targetGroup=t,this._bindings=t.subscribe_(e,r)}getValue(t,e){this.bind();let i=this._targetGroup.nCachedObjects_,r=this._bindings[i];r!==void 0&&r.getValue(t,e)}setValue(t,e){let i=this._bindings;for(let r=this._targetGroup.nCachedObjects_,s=i.length;r!==s;++r)i[r].setValue(t,e)}bind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,i=t.length;e!==i;++e)t[e].bind()}unbind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,i=t.length;e!==i;++e)t[e].unbind()}},St=class n{constructor(t,e,i){this.path=e,this.parsedPath=i||n.parseTrackName(e),this.node=n.findNode(t,this.parsedPath.nodeName),this.rootNode=t,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}static create(t,e,i){return t&&t.isAnimationObjectGroup?new n.Composite(t,e,i):new n(t,e,i)}static sanitizeNodeName(t){return t.replace(/\s/g,"_").replace(Gf,"")}static parseTrackName(t){let e=Yf.exec(t);if(e===null)throw new Error("THREE.PropertyBinding: Cannot parse trackName: "+t);let i={nodeName:e[2],objectName:e[3],objectIndex:e[4],propertyName:e[5],propertyIndex:e[6]},r=i.nodeName&&i.nodeName.lastIndexOf(".");if(r!==void 0&&r!==-1){let s=i.nodeName.substring(r+1);Zf.indexOf(s)!==-1&&(i.nodeName=i.nodeName.substring(0,r),i.objectName=s)}if(i.propertyName===null||i.propertyName.length===0)throw new Error("THREE.PropertyBinding: can not parse propertyName from trackName: "+t);return i}static findNode(t,e){if(e===void 0||e===""||e==="."||e===-1||e===t.name||e===t.uuid)return t;if(t.skeleton){let i=t.skeleton.getBoneByName(e);if(i!==void 0)return i}if(t.children){let i=function(s){for(let a=0;a<s.length;a++){let o=s[a];if(o.name===e||o.uuid===e)return o;let h=i(o.children);if(h)return h}return null},r=i(t.children);if(r)return r}return null}_getValue_unavailable(){}_setValue_unavailable(){}_getValue_direct(t,e){t[e]=this.targetObject[this.propertyName]}_getValue_array(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)t[e++]=i[r]}_getValue_arrayElement(t,e){t[e]=this.resolvedProperty[this.propertyIndex]}_getValue_toArray(t,e){this.resolvedProperty.toArray(t,e)}_setValue_direct(t,e){this.targetObject[this.propertyName]=t[e]}_setValue_direct_setNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.needsUpdate=!0}_setValue_direct_setMatrixWorldNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_array(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[e++]}_setValue_array_setNeedsUpdate(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[e++];this.targetObject.needsUpdate=!0}_setValue_array_setMatrixWorldNeedsUpdate(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[e++];this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_arrayElement(t,e){this.resolvedProperty[this.propertyIndex]=t[e]}_setValue_arrayElement_setNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.needsUpdate=!0}_setValue_arrayElement_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_fromArray(t,e){this.resolvedProperty.fromArray(t,e)}_setValue_fromArray_setNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.needsUpdate=!0}_setValue_fromArray_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.matrixWorldNeedsUpdate=!0}_getValue_unbound(t,e){this.bind(),this.getValue(t,e)}_setValue_unbound(t,e){this.bind(),this.setValue(t,e)}bind(){let t=this.node,e=this.parsedPath,i=e.objectName,r=e.propertyName,s=e.propertyIndex;if(t||(t=n.findNode(this.rootNode,e.nodeName),this.node=t),this.getValue=this._getValue_unavailable,this.setValue=this._setValue_unavailable,!t){$t("PropertyBinding: No target node found for track: "+this.path+".");return}if(i){let l=e.objectIndex;switch(i){case"materials":if(!t.material){Lt("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.materials){Lt("PropertyBinding: Can not bind to material.materials as node.material does not have a materials array.",this);return}t=t.material.materials;break;case"bones":if(!t.skeleton){Lt("PropertyBinding: Can not bind to bones as node does not have a skeleton.",this);return}t=t.skeleton.bones;for(let c=0;c<t.length;c++)if(t[c].name===l){l=c;break}break;case"map":if("map"in t){t=t.map;break}if(!t.material){Lt("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.map){Lt("PropertyBinding: Can not bind to material.map as node.material does not have a map.",this);return}t=t.material.map;break;default:if(t[i]===void 0){Lt("PropertyBinding: Can not bind to objectName of node undefined.",this);return}t=t[i]}if(l!==void 0){if(t[l]===void 0){Lt("PropertyBinding: Trying to bind to objectIndex of objectName, but is undefined.",this,t);return}t=t[l]}}let a=t[r];if(a===void 0){let l=e.nodeName;Lt("PropertyBinding: Trying to update property for track: "+l+"."+r+" but it wasn't found.",t);return}let o=this.Versioning.None;this.targetObject=t,t.isMaterial===!0?o=this.Versioning.NeedsUpdate:t.isObject3D===!0&&(o=this.Versioning.MatrixWorldNeedsUpdate);let h=this.BindingType.Direct;if(s!==void 0){if(r==="morphTargetInfluences"){if(!t.geometry){Lt("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.",this);return}if(!t.geometry.morphAttributes){Lt("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.morphAttributes.",this);return}t.morphTargetDictionary[s]!==void 0&&(s=t.morphTargetDictionary[s])}h=this.BindingType.ArrayElement,this.resolvedProperty=a,this.propertyIndex=s}else a.fromArray!==void 0&&a.toArray!==void 0?(h=this.BindingType.HasFromToArray,this.resolvedProperty=a):Array.isArray(a)?(h=this.BindingType.EntireArray,this.resolvedProperty=a):this.propertyName=r;this.getValue=this.GetterByBindingType[h],this.setValue=this.SetterByBindingTypeAndVersioning[h][o]}unbind(){this.node=null,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}};St.Composite=Ba;St.prototype.BindingType={Direct:0,EntireArray:1,ArrayElement:2,HasFromToArray:3};St.prototype.Versioning={None:0,NeedsUpdate:1,MatrixWorldNeedsUpdate:2};St.prototype.GetterByBindingType=[St.prototype._getValue_direct,St.prototype._getValue_array,St.prototype._getValue_arrayElement,St.prototype._getValue_toArray];St.prototype.SetterByBindingTypeAndVersioning=[[St.prototype._setValue_direct,St.prototype._setValue_direct_setNeedsUpdate,St.prototype._setValue_direct_setMatrixWorldNeedsUpdate],[St.prototype._setValue_array,St.prototype._setValue_array_setNeedsUpdate,St.prototype._setValue_array_setMatrixWorldNeedsUpdate],[St.prototype._setValue_arrayElement,St.prototype._setValue_arrayElement_setNeedsUpdate,St.prototype._setValue_arrayElement_setMatrixWorldNeedsUpdate],[St.prototype._setValue_fromArray,St.prototype._setValue_fromArray_setNeedsUpdate,St.prototype._setValue_fromArray_setMatrixWorldNeedsUpdate]];var M1=new Float32Array(1);var Yl=class{static{this.prototype.isMatrix2=!0}constructor(t,e,i,r){this.elements=[1,0,0,1],t!==void 0&&this.set(t,e,i,r)}identity(){return this.set(1,0,0,1),this}fromArray(t,e=0){for(let i=0;i<4;i++)this.elements[i]=t[i+e];return this}set(t,e,i,r){let s=this.elements;return s[0]=t,s[2]=e,s[1]=i,s[3]=r,this}};typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("register",{detail:{revision:"187"}}));typeof window<"u"&&(window.__THREE__?$t("WARNING: Multiple instances of Three.js being imported."):window.__THREE__="187");var Jf=`#ifdef USE_ALPHAHASH
	if ( diffuseColor.a < getAlphaHashThreshold( vPosition ) ) discard;
#endif`,$f=`#ifdef USE_ALPHAHASH
	const float ALPHA_HASH_SCALE = 0.05;
	float hash2D( vec2 value ) {
		return fract( 1.0e4 * sin( 17.0 * value.x + 0.1 * value.y ) * ( 0.1 + abs( sin( 13.0 * value.y + value.x ) ) ) );
	}
	float hash3D( vec3 value ) {
		return hash2D( vec2( hash2D( value.xy ), value.z ) );
	}
	float getAlphaHashThreshold( vec3 position ) {
		float maxDeriv = max(
			length( dFdx( position.xyz ) ),
			length( dFdy( position.xyz ) )
		);
		float pixScale = 1.0 / ( ALPHA_HASH_SCALE * maxDeriv );
		vec2 pixScales = vec2(
			exp2( floor( log2( pixScale ) ) ),
			exp2( ceil( log2( pixScale ) ) )
		);
		vec2 alpha = vec2(
			hash3D( floor( pixScales.x * position.xyz ) ),
			hash3D( floor( pixScales.y * position.xyz ) )
		);
		float lerpFactor = fract( log2( pixScale ) );
		float x = ( 1.0 - lerpFactor ) * alpha.x + lerpFactor * alpha.y;
		float a = min( lerpFactor, 1.0 - lerpFactor );
		vec3 cases = vec3(
			x * x / ( 2.0 * a * ( 1.0 - a ) ),
			( x - 0.5 * a ) / ( 1.0 - a ),
			1.0 - ( ( 1.0 - x ) * ( 1.0 - x ) / ( 2.0 * a * ( 1.0 - a ) ) )
		);
		float threshold = ( x < ( 1.0 - a ) )
			? ( ( x < a ) ? cases.x : cases.y )
			: cases.z;
		return clamp( threshold , 1.0e-6, 1.0 );
	}
#endif`,Kf=`#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, vAlphaMapUv ).g;
#endif`,Qf=`#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,jf=`#ifdef USE_ALPHATEST
	#ifdef ALPHA_TO_COVERAGE
	diffuseColor.a = smoothstep( alphaTest, alphaTest + fwidth( diffuseColor.a ), diffuseColor.a );
	if ( diffuseColor.a == 0.0 ) discard;
	#else
	if ( diffuseColor.a < alphaTest ) discard;
	#endif
#endif`,td=`#ifdef USE_ALPHATEST
	uniform float alphaTest;
#endif`,ed=`#ifdef USE_AOMAP
	float ambientOcclusion = ( texture2D( aoMap, vAoMapUv ).r - 1.0 ) * aoMapIntensity + 1.0;
	reflectedLight.indirectDiffuse *= ambientOcclusion;
	#if defined( USE_CLEARCOAT ) 
		clearcoatSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_SHEEN ) 
		sheenSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_ENVMAP ) && defined( STANDARD )
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		reflectedLight.indirectSpecular *= computeSpecularOcclusion( dotNV, ambientOcclusion, material.roughness );
	#endif
#endif`,nd=`#ifdef USE_AOMAP
	uniform sampler2D aoMap;
	uniform float aoMapIntensity;
#endif`,id=`#ifdef USE_BATCHING
	#if ! defined( GL_ANGLE_multi_draw )
	#define gl_DrawID _gl_DrawID
	uniform int _gl_DrawID;
	#endif
	uniform highp sampler2D batchingTexture;
	uniform highp usampler2D batchingIdTexture;
	mat4 getBatchingMatrix( const in float i ) {
		int size = textureSize( batchingTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( batchingTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( batchingTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( batchingTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( batchingTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
	float getIndirectIndex( const in int i ) {
		int size = textureSize( batchingIdTexture, 0 ).x;
		int x = i % size;
		int y = i / size;
		return float( texelFetch( batchingIdTexture, ivec2( x, y ), 0 ).r );
	}
#endif
#ifdef USE_BATCHING_COLOR
	uniform sampler2D batchingColorTexture;
	vec4 getBatchingColor( const in float i ) {
		int size = textureSize( batchingColorTexture, 0 ).x;
		int j = int( i );
		int x = j % size;
		int y = j / size;
		return texelFetch( batchingColorTexture, ivec2( x, y ), 0 );
	}
#endif`,rd=`#ifdef USE_BATCHING
	mat4 batchingMatrix = getBatchingMatrix( getIndirectIndex( gl_DrawID ) );
#endif`,sd=`vec3 transformed = vec3( position );
#ifdef USE_ALPHAHASH
	vPosition = vec3( position );
#endif`,ad=`vec3 objectNormal = vec3( normal );
#ifdef USE_TANGENT
	vec3 objectTangent = vec3( tangent.xyz );
#endif`,od=`float G_BlinnPhong_Implicit( ) {
	return 0.25;
}
float D_BlinnPhong( const in float shininess, const in float dotNH ) {
	return RECIPROCAL_PI * ( shininess * 0.5 + 1.0 ) * pow( dotNH, shininess );
}
vec3 BRDF_BlinnPhong( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 specularColor, const in float shininess ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( specularColor, 1.0, dotVH );
	float G = G_BlinnPhong_Implicit( );
	float D = D_BlinnPhong( shininess, dotNH );
	return F * ( G * D );
} // validated`,ld=`#ifdef USE_IRIDESCENCE
	const mat3 XYZ_TO_REC709 = mat3(
		 3.2404542, -0.9692660,  0.0556434,
		-1.5371385,  1.8760108, -0.2040259,
		-0.4985314,  0.0415560,  1.0572252
	);
	vec3 Fresnel0ToIor( vec3 fresnel0 ) {
		vec3 sqrtF0 = sqrt( fresnel0 );
		return ( vec3( 1.0 ) + sqrtF0 ) / ( vec3( 1.0 ) - sqrtF0 );
	}
	vec3 IorToFresnel0( vec3 transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - vec3( incidentIor ) ) / ( transmittedIor + vec3( incidentIor ) ) );
	}
	float IorToFresnel0( float transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - incidentIor ) / ( transmittedIor + incidentIor ));
	}
	vec3 evalSensitivity( float OPD, vec3 shift ) {
		float phase = 2.0 * PI * OPD * 1.0e-9;
		vec3 val = vec3( 5.4856e-13, 4.4201e-13, 5.2481e-13 );
		vec3 pos = vec3( 1.6810e+06, 1.7953e+06, 2.2084e+06 );
		vec3 var = vec3( 4.3278e+09, 9.3046e+09, 6.6121e+09 );
		vec3 xyz = val * sqrt( 2.0 * PI * var ) * cos( pos * phase + shift ) * exp( - pow2( phase ) * var );
		xyz.x += 9.7470e-14 * sqrt( 2.0 * PI * 4.5282e+09 ) * cos( 2.2399e+06 * phase + shift[ 0 ] ) * exp( - 4.5282e+09 * pow2( phase ) );
		xyz /= 1.0685e-7;
		vec3 rgb = XYZ_TO_REC709 * xyz;
		return rgb;
	}
	vec3 evalIridescence( float outsideIOR, float eta2, float cosTheta1, float thinFilmThickness, vec3 baseF0 ) {
		vec3 I;
		float iridescenceIOR = mix( outsideIOR, eta2, smoothstep( 0.0, 0.03, thinFilmThickness ) );
		float sinTheta2Sq = pow2( outsideIOR / iridescenceIOR ) * ( 1.0 - pow2( cosTheta1 ) );
		float cosTheta2Sq = 1.0 - sinTheta2Sq;
		if ( cosTheta2Sq < 0.0 ) {
			return vec3( 1.0 );
		}
		float cosTheta2 = sqrt( cosTheta2Sq );
		float R0 = IorToFresnel0( iridescenceIOR, outsideIOR );
		float R12 = F_Schlick( R0, 1.0, cosTheta1 );
		float T121 = 1.0 - R12;
		float phi12 = 0.0;
		if ( iridescenceIOR < outsideIOR ) phi12 = PI;
		float phi21 = PI - phi12;
		vec3 baseIOR = Fresnel0ToIor( clamp( baseF0, 0.0, 0.9999 ) );		vec3 R1 = IorToFresnel0( baseIOR, iridescenceIOR );
		vec3 R23 = F_Schlick( R1, 1.0, cosTheta2 );
		vec3 phi23 = vec3( 0.0 );
		if ( baseIOR[ 0 ] < iridescenceIOR ) phi23[ 0 ] = PI;
		if ( baseIOR[ 1 ] < iridescenceIOR ) phi23[ 1 ] = PI;
		if ( baseIOR[ 2 ] < iridescenceIOR ) phi23[ 2 ] = PI;
		float OPD = 2.0 * iridescenceIOR * thinFilmThickness * cosTheta2;
		vec3 phi = vec3( phi21 ) + phi23;
		vec3 R123 = clamp( R12 * R23, 1e-5, 0.9999 );
		vec3 r123 = sqrt( R123 );
		vec3 Rs = pow2( T121 ) * R23 / ( vec3( 1.0 ) - R123 );
		vec3 C0 = R12 + Rs;
		I = C0;
		vec3 Cm = Rs - T121;
		for ( int m = 1; m <= 2; ++ m ) {
			Cm *= r123;
			vec3 Sm = 2.0 * evalSensitivity( float( m ) * OPD, float( m ) * phi );
			I += Cm * Sm;
		}
		return max( I, vec3( 0.0 ) );
	}
#endif`,cd=`#ifdef USE_BUMPMAP
	uniform sampler2D bumpMap;
	uniform float bumpScale;
	vec2 dHdxy_fwd() {
		vec2 dSTdx = dFdx( vBumpMapUv );
		vec2 dSTdy = dFdy( vBumpMapUv );
		float Hll = bumpScale * texture2D( bumpMap, vBumpMapUv ).x;
		float dBx = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdx ).x - Hll;
		float dBy = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdy ).x - Hll;
		return vec2( dBx, dBy );
	}
	vec3 perturbNormalArb( vec3 surf_pos, vec3 surf_norm, vec2 dHdxy, float faceDirection ) {
		vec3 vSigmaX = normalize( dFdx( surf_pos.xyz ) );
		vec3 vSigmaY = normalize( dFdy( surf_pos.xyz ) );
		vec3 vN = surf_norm;
		vec3 R1 = cross( vSigmaY, vN );
		vec3 R2 = cross( vN, vSigmaX );
		float fDet = dot( vSigmaX, R1 ) * faceDirection;
		vec3 vGrad = sign( fDet ) * ( dHdxy.x * R1 + dHdxy.y * R2 );
		return normalize( abs( fDet ) * surf_norm - vGrad );
	}
#endif`,hd=`#if NUM_CLIPPING_PLANES > 0
	vec4 plane;
	#ifdef ALPHA_TO_COVERAGE
		float distanceToPlane, distanceGradient;
		float clipOpacity = 1.0;
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
			distanceGradient = fwidth( distanceToPlane ) / 2.0;
			clipOpacity *= smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			if ( clipOpacity == 0.0 ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			float unionClipOpacity = 1.0;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
				distanceGradient = fwidth( distanceToPlane ) / 2.0;
				unionClipOpacity *= 1.0 - smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			}
			#pragma unroll_loop_end
			clipOpacity *= 1.0 - unionClipOpacity;
		#endif
		diffuseColor.a *= clipOpacity;
		if ( diffuseColor.a == 0.0 ) discard;
	#else
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			if ( dot( vClipPosition, plane.xyz ) > plane.w ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			bool clipped = true;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				clipped = ( dot( vClipPosition, plane.xyz ) > plane.w ) && clipped;
			}
			#pragma unroll_loop_end
			if ( clipped ) discard;
		#endif
	#endif
#endif`,ud=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
	uniform vec4 clippingPlanes[ NUM_CLIPPING_PLANES ];
#endif`,fd=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
#endif`,dd=`#if NUM_CLIPPING_PLANES > 0
	vClipPosition = - mvPosition.xyz;
#endif`,pd=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	diffuseColor *= vColor;
#endif`,md=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	varying vec4 vColor;
#endif`,gd=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	varying vec4 vColor;
#endif`,_d=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	vColor = vec4( 1.0 );
#endif
#ifdef USE_COLOR_ALPHA
	vColor *= color;
#elif defined( USE_COLOR )
	vColor.rgb *= color;
#endif
#ifdef USE_INSTANCING_COLOR
	vColor.rgb *= instanceColor.rgb;
#endif
#ifdef USE_BATCHING_COLOR
	vColor *= getBatchingColor( getIndirectIndex( gl_DrawID ) );
#endif`,xd=`#define PI 3.141592653589793
#define PI2 6.283185307179586
#define PI_HALF 1.5707963267948966
#define RECIPROCAL_PI 0.3183098861837907
#define RECIPROCAL_PI2 0.15915494309189535
#define EPSILON 1e-6
#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
#define whiteComplement( a ) ( 1.0 - saturate( a ) )
float pow2( const in float x ) { return x*x; }
vec3 pow2( const in vec3 x ) { return x*x; }
float pow3( const in float x ) { return x*x*x; }
float pow4( const in float x ) { float x2 = x*x; return x2*x2; }
float max3( const in vec3 v ) { return max( max( v.x, v.y ), v.z ); }
float average( const in vec3 v ) { return dot( v, vec3( 0.3333333 ) ); }
highp float rand( const in vec2 uv ) {
	const highp float a = 12.9898, b = 78.233, c = 43758.5453;
	highp float dt = dot( uv.xy, vec2( a,b ) ), sn = mod( dt, PI );
	return fract( sin( sn ) * c );
}
#ifdef HIGH_PRECISION
	float precisionSafeLength( vec3 v ) { return length( v ); }
#else
	float precisionSafeLength( vec3 v ) {
		float maxComponent = max3( abs( v ) );
		return length( v / maxComponent ) * maxComponent;
	}
#endif
struct IncidentLight {
	vec3 color;
	vec3 direction;
	bool visible;
};
struct ReflectedLight {
	vec3 directDiffuse;
	vec3 directSpecular;
	vec3 indirectDiffuse;
	vec3 indirectSpecular;
};
#ifdef USE_ALPHAHASH
	varying vec3 vPosition;
#endif
vec3 transformDirection( in vec3 dir, in mat4 matrix ) {
	return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );
}
#define inverseTransformDirection transformDirectionByInverseViewMatrix
vec3 transformNormalByInverseViewMatrix( in vec3 normal, in mat4 viewMatrix ) {
	return normalize( ( vec4( normal, 0.0 ) * viewMatrix ).xyz );
}
vec3 transformDirectionByInverseViewMatrix( in vec3 dir, in mat4 viewMatrix ) {
	return normalize( ( vec4( dir, 0.0 ) * viewMatrix ).xyz );
}
bool isPerspectiveMatrix( mat4 m ) {
	return m[ 2 ][ 3 ] == - 1.0;
}
vec2 equirectUv( in vec3 dir ) {
	float u = atan( dir.z, dir.x ) * RECIPROCAL_PI2 + 0.5;
	float v = asin( clamp( dir.y, - 1.0, 1.0 ) ) * RECIPROCAL_PI + 0.5;
	return vec2( u, v );
}
vec3 BRDF_Lambert( const in vec3 diffuseColor ) {
	return RECIPROCAL_PI * diffuseColor;
}
vec3 F_Schlick( const in vec3 f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
}
float F_Schlick( const in float f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
} // validated`,vd=`vec3 transformedNormal = objectNormal;
#ifdef USE_TANGENT
	vec3 transformedTangent = objectTangent;
#endif
#ifdef USE_BATCHING
	mat3 bm = mat3( batchingMatrix );
	transformedNormal /= vec3( dot( bm[ 0 ], bm[ 0 ] ), dot( bm[ 1 ], bm[ 1 ] ), dot( bm[ 2 ], bm[ 2 ] ) );
	transformedNormal = bm * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = bm * transformedTangent;
	#endif
#endif
#ifdef USE_INSTANCING
	mat3 im = mat3( instanceMatrix );
	transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );
	transformedNormal = im * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = im * transformedTangent;
	#endif
#endif
transformedNormal = normalMatrix * transformedNormal;
#ifdef FLIP_SIDED
	transformedNormal = - transformedNormal;
#endif
#ifdef USE_TANGENT
	transformedTangent = ( modelViewMatrix * vec4( transformedTangent, 0.0 ) ).xyz;
#endif`,yd=`#ifdef USE_DISPLACEMENTMAP
	uniform sampler2D displacementMap;
	uniform float displacementScale;
	uniform float displacementBias;
#endif`,Sd=`#ifdef USE_DISPLACEMENTMAP
	transformed += normalize( objectNormal ) * ( texture2D( displacementMap, vDisplacementMapUv ).x * displacementScale + displacementBias );
#endif`,Md=`#ifdef USE_EMISSIVEMAP
	vec4 emissiveColor = texture2D( emissiveMap, vEmissiveMapUv );
	#ifdef DECODE_VIDEO_TEXTURE_EMISSIVE
		emissiveColor = sRGBTransferEOTF( emissiveColor );
	#endif
	totalEmissiveRadiance *= emissiveColor.rgb;
#endif`,bd=`#ifdef USE_EMISSIVEMAP
	uniform sampler2D emissiveMap;
#endif`,wd="gl_FragColor = linearToOutputTexel( gl_FragColor );",Ed=`vec4 LinearTransferOETF( in vec4 value ) {
	return value;
}
vec4 sRGBTransferEOTF( in vec4 value ) {
	return vec4( mix( pow( value.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), value.rgb * 0.0773993808, vec3( lessThanEqual( value.rgb, vec3( 0.04045 ) ) ) ), value.a );
}
vec4 sRGBTransferOETF( in vec4 value ) {
	return vec4( mix( pow( value.rgb, vec3( 0.41666 ) ) * 1.055 - vec3( 0.055 ), value.rgb * 12.92, vec3( lessThanEqual( value.rgb, vec3( 0.0031308 ) ) ) ), value.a );
}`,Ad=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vec3 cameraToFrag;
		if ( isOrthographic ) {
			cameraToFrag = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToFrag = normalize( vWorldPosition - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vec3 reflectVec = reflect( cameraToFrag, worldNormal );
		#else
			vec3 reflectVec = refract( cameraToFrag, worldNormal, refractionRatio );
		#endif
	#else
		vec3 reflectVec = vReflect;
	#endif
	#ifdef ENVMAP_TYPE_CUBE
		vec4 envColor = textureCube( envMap, envMapRotation * reflectVec );
		#ifdef ENVMAP_BLENDING_MULTIPLY
			outgoingLight = mix( outgoingLight, outgoingLight * envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_MIX )
			outgoingLight = mix( outgoingLight, envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_ADD )
			outgoingLight += envColor.xyz * specularStrength * reflectivity;
		#endif
	#endif
#endif`,Td=`#ifdef USE_ENVMAP
	uniform float envMapIntensity;
	uniform mat3 envMapRotation;
	uniform samplerCube envMap;
	#ifdef ENVMAP_TYPE_PMREM
		float roughnessToMip( const in float roughness ) {
			float r = clamp( roughness, 0.0, 1.0 );
			return ENVMAP_MAX_LOD * r * ( 2.0 - r );
		}
	#endif
#endif`,Rd=`#ifdef USE_ENVMAP
	uniform float reflectivity;
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		varying vec3 vWorldPosition;
		uniform float refractionRatio;
	#else
		varying vec3 vReflect;
	#endif
#endif`,Cd=`#ifdef USE_ENVMAP
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		
		varying vec3 vWorldPosition;
	#else
		varying vec3 vReflect;
		uniform float refractionRatio;
	#endif
#endif`,Id=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vWorldPosition = worldPosition.xyz;
	#else
		vec3 cameraToVertex;
		if ( isOrthographic ) {
			cameraToVertex = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToVertex = normalize( worldPosition.xyz - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vReflect = reflect( cameraToVertex, worldNormal );
		#else
			vReflect = refract( cameraToVertex, worldNormal, refractionRatio );
		#endif
	#endif
#endif`,Pd=`#ifdef USE_FOG
	vFogDepth = - mvPosition.z;
#endif`,Nd=`#ifdef USE_FOG
	varying float vFogDepth;
#endif`,Ld=`#ifdef USE_FOG
	#ifdef FOG_EXP2
		float fogFactor = 1.0 - exp( - fogDensity * fogDensity * vFogDepth * vFogDepth );
	#else
		float fogFactor = smoothstep( fogNear, fogFar, vFogDepth );
	#endif
	gl_FragColor.rgb = mix( gl_FragColor.rgb, fogColor, fogFactor );
#endif`,Dd=`#ifdef USE_FOG
	uniform vec3 fogColor;
	varying float vFogDepth;
	#ifdef FOG_EXP2
		uniform float fogDensity;
	#else
		uniform float fogNear;
		uniform float fogFar;
	#endif
#endif`,Ud=`#ifdef USE_GRADIENTMAP
	uniform sampler2D gradientMap;
#endif
vec3 getGradientIrradiance( vec3 normal, vec3 lightDirection ) {
	float dotNL = dot( normal, lightDirection );
	vec2 coord = vec2( dotNL * 0.5 + 0.5, 0.0 );
	#ifdef USE_GRADIENTMAP
		return vec3( texture2D( gradientMap, coord ).r );
	#else
		vec2 fw = fwidth( coord ) * 0.5;
		return mix( vec3( 0.7 ), vec3( 1.0 ), smoothstep( 0.7 - fw.x, 0.7 + fw.x, coord.x ) );
	#endif
}`,Fd=`#ifdef USE_LIGHTMAP
	uniform sampler2D lightMap;
	uniform float lightMapIntensity;
#endif`,Od=`LambertMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularStrength = specularStrength;`,Bd=`varying vec3 vViewPosition;
struct LambertMaterial {
	vec3 diffuseColor;
	float specularStrength;
};
void RE_Direct_Lambert( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Lambert( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Lambert
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Lambert`,zd=`uniform bool receiveShadow;
uniform vec3 ambientLightColor;
#if defined( USE_LIGHT_PROBES )
	uniform vec3 lightProbe[ 9 ];
#endif
vec3 shGetIrradianceAt( in vec3 normal, in vec3 shCoefficients[ 9 ] ) {
	float x = normal.x, y = normal.y, z = normal.z;
	vec3 result = shCoefficients[ 0 ] * 0.886227;
	result += shCoefficients[ 1 ] * 2.0 * 0.511664 * y;
	result += shCoefficients[ 2 ] * 2.0 * 0.511664 * z;
	result += shCoefficients[ 3 ] * 2.0 * 0.511664 * x;
	result += shCoefficients[ 4 ] * 2.0 * 0.429043 * x * y;
	result += shCoefficients[ 5 ] * 2.0 * 0.429043 * y * z;
	result += shCoefficients[ 6 ] * ( 0.743125 * z * z - 0.247708 );
	result += shCoefficients[ 7 ] * 2.0 * 0.429043 * x * z;
	result += shCoefficients[ 8 ] * 0.429043 * ( x * x - y * y );
	return result;
}
vec3 getLightProbeIrradiance( const in vec3 lightProbe[ 9 ], const in vec3 normal ) {
	vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec3 irradiance = shGetIrradianceAt( worldNormal, lightProbe );
	return irradiance;
}
vec3 getAmbientLightIrradiance( const in vec3 ambientLightColor ) {
	vec3 irradiance = ambientLightColor;
	return irradiance;
}
float getDistanceAttenuation( const in float lightDistance, const in float cutoffDistance, const in float decayExponent ) {
	float distanceFalloff = 1.0 / max( pow( lightDistance, decayExponent ), 0.01 );
	if ( cutoffDistance > 0.0 ) {
		distanceFalloff *= pow2( saturate( 1.0 - pow4( lightDistance / cutoffDistance ) ) );
	}
	return distanceFalloff;
}
float getSpotAttenuation( const in float coneCosine, const in float penumbraCosine, const in float angleCosine ) {
	return smoothstep( coneCosine, penumbraCosine, angleCosine );
}
#if NUM_SUN_LIGHTS > 0
	struct SunLight {
		vec3 direction;
		vec3 color;
	};
	uniform SunLight sunLights[ NUM_SUN_LIGHTS ];
	void getSunLightInfo( const in SunLight sunLight, out IncidentLight light ) {
		light.color = sunLight.color;
		light.direction = sunLight.direction;
		light.visible = true;
	}
#endif
#if NUM_DIR_LIGHTS > 0
	struct DirectionalLight {
		vec3 direction;
		vec3 color;
	};
	uniform DirectionalLight directionalLights[ NUM_DIR_LIGHTS ];
	void getDirectionalLightInfo( const in DirectionalLight directionalLight, out IncidentLight light ) {
		light.color = directionalLight.color;
		light.direction = directionalLight.direction;
		light.visible = true;
	}
#endif
#if NUM_POINT_LIGHTS > 0
	struct PointLight {
		vec3 position;
		vec3 color;
		float distance;
		float decay;
	};
	uniform PointLight pointLights[ NUM_POINT_LIGHTS ];
	void getPointLightInfo( const in PointLight pointLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = pointLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float lightDistance = length( lVector );
		light.color = pointLight.color;
		light.color *= getDistanceAttenuation( lightDistance, pointLight.distance, pointLight.decay );
		light.visible = ( light.color != vec3( 0.0 ) );
	}
#endif
#if NUM_SPOT_LIGHTS > 0
	struct SpotLight {
		vec3 position;
		vec3 direction;
		vec3 color;
		float distance;
		float decay;
		float coneCos;
		float penumbraCos;
	};
	uniform SpotLight spotLights[ NUM_SPOT_LIGHTS ];
	void getSpotLightInfo( const in SpotLight spotLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = spotLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float angleCos = dot( light.direction, spotLight.direction );
		float spotAttenuation = getSpotAttenuation( spotLight.coneCos, spotLight.penumbraCos, angleCos );
		if ( spotAttenuation > 0.0 ) {
			float lightDistance = length( lVector );
			light.color = spotLight.color * spotAttenuation;
			light.color *= getDistanceAttenuation( lightDistance, spotLight.distance, spotLight.decay );
			light.visible = ( light.color != vec3( 0.0 ) );
		} else {
			light.color = vec3( 0.0 );
			light.visible = false;
		}
	}
#endif
#if NUM_RECT_AREA_LIGHTS > 0
	struct RectAreaLight {
		vec3 color;
		vec3 position;
		vec3 halfWidth;
		vec3 halfHeight;
	};
	uniform sampler2D ltc_1;	uniform sampler2D ltc_2;
	uniform RectAreaLight rectAreaLights[ NUM_RECT_AREA_LIGHTS ];
#endif
#if NUM_HEMI_LIGHTS > 0
	struct HemisphereLight {
		vec3 direction;
		vec3 skyColor;
		vec3 groundColor;
	};
	uniform HemisphereLight hemisphereLights[ NUM_HEMI_LIGHTS ];
	vec3 getHemisphereLightIrradiance( const in HemisphereLight hemiLight, const in vec3 normal ) {
		float dotNL = dot( normal, hemiLight.direction );
		float hemiDiffuseWeight = 0.5 * dotNL + 0.5;
		vec3 irradiance = mix( hemiLight.groundColor, hemiLight.skyColor, hemiDiffuseWeight );
		return irradiance;
	}
#endif
#include <lightprobes_pars_fragment>`,kd=`#ifdef USE_ENVMAP
	vec3 getIBLIrradiance( const in vec3 normal ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * worldNormal, ENVMAP_MAX_LOD );
			return PI * envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	vec3 getIBLRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 reflectVec = reflect( - viewDir, normal );
			reflectVec = normalize( mix( reflectVec, normal, pow4( roughness ) ) );
			reflectVec = transformDirectionByInverseViewMatrix( reflectVec, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * reflectVec, roughnessToMip( roughness ) );
			return envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	#ifdef USE_RETROREFLECTION
		vec3 getIBLRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 retroVec = normalize( mix( viewDir, normal, pow4( roughness ) ) );
				retroVec = transformDirectionByInverseViewMatrix( retroVec, viewMatrix );
				vec4 envMapColor = textureLod( envMap, envMapRotation * retroVec, roughnessToMip( roughness ) );
				return envMapColor.rgb * envMapIntensity;
			#else
				return vec3( 0.0 );
			#endif
		}
	#endif
	#ifdef USE_ANISOTROPY
		vec3 getIBLAnisotropyRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 bentNormal = cross( bitangent, viewDir );
				bentNormal = normalize( cross( bentNormal, bitangent ) );
				bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
				return getIBLRadiance( viewDir, bentNormal, roughness );
			#else
				return vec3( 0.0 );
			#endif
		}
		#ifdef USE_RETROREFLECTION
			vec3 getIBLAnisotropyRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
				#ifdef ENVMAP_TYPE_PMREM
					vec3 bentNormal = cross( bitangent, viewDir );
					bentNormal = normalize( cross( bentNormal, bitangent ) );
					bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
					return getIBLRetroRadiance( viewDir, bentNormal, roughness );
				#else
					return vec3( 0.0 );
				#endif
			}
		#endif
	#endif
#endif`,Gd=`ToonMaterial material;
material.diffuseColor = diffuseColor.rgb;`,Vd=`varying vec3 vViewPosition;
struct ToonMaterial {
	vec3 diffuseColor;
};
void RE_Direct_Toon( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 irradiance = getGradientIrradiance( geometryNormal, directLight.direction ) * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Toon( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Toon
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Toon`,Hd=`BlinnPhongMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularColor = specular;
material.specularShininess = shininess;
material.specularStrength = specularStrength;`,Wd=`varying vec3 vViewPosition;
struct BlinnPhongMaterial {
	vec3 diffuseColor;
	vec3 specularColor;
	float specularShininess;
	float specularStrength;
};
void RE_Direct_BlinnPhong( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
	reflectedLight.directSpecular += irradiance * BRDF_BlinnPhong( directLight.direction, geometryViewDir, geometryNormal, material.specularColor, material.specularShininess ) * material.specularStrength;
}
void RE_IndirectDiffuse_BlinnPhong( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_BlinnPhong
#define RE_IndirectDiffuse		RE_IndirectDiffuse_BlinnPhong`,Xd=`PhysicalMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.diffuseContribution = diffuseColor.rgb * ( 1.0 - metalnessFactor );
material.metalness = metalnessFactor;
vec3 dxy = max( abs( dFdx( nonPerturbedNormal ) ), abs( dFdy( nonPerturbedNormal ) ) );
float geometryRoughness = max( max( dxy.x, dxy.y ), dxy.z );
material.roughness = max( roughnessFactor, 0.045 );
material.roughness += geometryRoughness;
material.roughness = min( material.roughness, 1.0 );
#ifdef USE_DIFFUSE_ROUGHNESS
	float diffuseRoughnessFactor = diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		diffuseRoughnessFactor *= texture2D( diffuseRoughnessMap, vDiffuseRoughnessMapUv ).r;
	#endif
	material.diffuseRoughness = saturate( diffuseRoughnessFactor );
#endif
#ifdef IOR
	material.ior = ior;
	#ifdef USE_SPECULAR
		float specularIntensityFactor = specularIntensity;
		vec3 specularColorFactor = specularColor;
		#ifdef USE_SPECULAR_COLORMAP
			specularColorFactor *= texture2D( specularColorMap, vSpecularColorMapUv ).rgb;
		#endif
		#ifdef USE_SPECULAR_INTENSITYMAP
			specularIntensityFactor *= texture2D( specularIntensityMap, vSpecularIntensityMapUv ).a;
		#endif
		material.specularF90 = mix( specularIntensityFactor, 1.0, metalnessFactor );
	#else
		float specularIntensityFactor = 1.0;
		vec3 specularColorFactor = vec3( 1.0 );
		material.specularF90 = 1.0;
	#endif
	material.specularColor = min( pow2( ( material.ior - 1.0 ) / ( material.ior + 1.0 ) ) * specularColorFactor, vec3( 1.0 ) ) * specularIntensityFactor;
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
#else
	material.specularColor = vec3( 0.04 );
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
	material.specularF90 = 1.0;
#endif
#ifdef USE_CLEARCOAT
	material.clearcoat = clearcoat;
	material.clearcoatRoughness = clearcoatRoughness;
	material.clearcoatF0 = vec3( 0.04 );
	material.clearcoatF90 = 1.0;
	#ifdef USE_CLEARCOATMAP
		material.clearcoat *= texture2D( clearcoatMap, vClearcoatMapUv ).x;
	#endif
	#ifdef USE_CLEARCOAT_ROUGHNESSMAP
		material.clearcoatRoughness *= texture2D( clearcoatRoughnessMap, vClearcoatRoughnessMapUv ).y;
	#endif
	material.clearcoat = saturate( material.clearcoat );	material.clearcoatRoughness = max( material.clearcoatRoughness, 0.045 );
	material.clearcoatRoughness += geometryRoughness;
	material.clearcoatRoughness = min( material.clearcoatRoughness, 1.0 );
#endif
#ifdef USE_DISPERSION
	material.dispersion = dispersion;
#endif
#ifdef USE_RETROREFLECTION
	material.retroreflectivity = retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	material.iridescence = iridescence;
	material.iridescenceIOR = iridescenceIOR;
	#ifdef USE_IRIDESCENCEMAP
		material.iridescence *= texture2D( iridescenceMap, vIridescenceMapUv ).r;
	#endif
	#ifdef USE_IRIDESCENCE_THICKNESSMAP
		material.iridescenceThickness = (iridescenceThicknessMaximum - iridescenceThicknessMinimum) * texture2D( iridescenceThicknessMap, vIridescenceThicknessMapUv ).g + iridescenceThicknessMinimum;
	#else
		material.iridescenceThickness = iridescenceThicknessMaximum;
	#endif
#endif
#ifdef USE_SHEEN
	material.sheenColor = sheenColor;
	#ifdef USE_SHEEN_COLORMAP
		material.sheenColor *= texture2D( sheenColorMap, vSheenColorMapUv ).rgb;
	#endif
	material.sheenRoughness = clamp( sheenRoughness, 0.0001, 1.0 );
	#ifdef USE_SHEEN_ROUGHNESSMAP
		material.sheenRoughness *= texture2D( sheenRoughnessMap, vSheenRoughnessMapUv ).a;
	#endif
#endif
#ifdef USE_ANISOTROPY
	#ifdef USE_ANISOTROPYMAP
		mat2 anisotropyMat = mat2( anisotropyVector.x, anisotropyVector.y, - anisotropyVector.y, anisotropyVector.x );
		vec3 anisotropyPolar = texture2D( anisotropyMap, vAnisotropyMapUv ).rgb;
		vec2 anisotropyV = anisotropyMat * normalize( 2.0 * anisotropyPolar.rg - vec2( 1.0 ) ) * anisotropyPolar.b;
	#else
		vec2 anisotropyV = anisotropyVector;
	#endif
	material.anisotropy = length( anisotropyV );
	if( material.anisotropy == 0.0 ) {
		anisotropyV = vec2( 1.0, 0.0 );
	} else {
		anisotropyV /= material.anisotropy;
		material.anisotropy = saturate( material.anisotropy );
	}
	material.alphaT = mix( pow2( material.roughness ), 1.0, pow2( material.anisotropy ) );
	material.anisotropyT = tbn[ 0 ] * anisotropyV.x + tbn[ 1 ] * anisotropyV.y;
	material.anisotropyB = tbn[ 1 ] * anisotropyV.x - tbn[ 0 ] * anisotropyV.y;
#endif`,qd=`uniform sampler2D dfgLUT;
struct PhysicalMaterial {
	vec3 diffuseColor;
	vec3 diffuseContribution;
	vec3 specularColor;
	vec3 specularColorBlended;
	float roughness;
	float metalness;
	float specularF90;
	float dispersion;
	vec2 dfg;
	vec3 multiScatteringCompensation;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float diffuseRoughness;
	#endif
	#ifdef USE_RETROREFLECTION
		float retroreflectivity;
	#endif
	#ifdef USE_CLEARCOAT
		float clearcoat;
		float clearcoatRoughness;
		vec3 clearcoatF0;
		float clearcoatF90;
	#endif
	#ifdef USE_IRIDESCENCE
		float iridescence;
		float iridescenceIOR;
		float iridescenceThickness;
		vec3 iridescenceFresnel;
		vec3 iridescenceF0Dielectric;
		vec3 iridescenceF0Metallic;
	#endif
	#ifdef USE_SHEEN
		vec3 sheenColor;
		float sheenRoughness;
	#endif
	#ifdef IOR
		float ior;
	#endif
	#ifdef USE_TRANSMISSION
		float transmission;
		float transmissionAlpha;
		float thickness;
		float attenuationDistance;
		vec3 attenuationColor;
	#endif
	#ifdef USE_ANISOTROPY
		float anisotropy;
		float alphaT;
		vec3 anisotropyT;
		vec3 anisotropyB;
	#endif
};
vec3 clearcoatSpecularDirect = vec3( 0.0 );
vec3 clearcoatSpecularIndirect = vec3( 0.0 );
vec3 sheenSpecularDirect = vec3( 0.0 );
vec3 sheenSpecularIndirect = vec3(0.0 );
vec3 Schlick_to_F0( const in vec3 f, const in float f90, const in float dotVH ) {
    float x = clamp( 1.0 - dotVH, 0.0, 1.0 );
    float x2 = x * x;
    float x5 = clamp( x * x2 * x2, 0.0, 0.9999 );
    return ( f - vec3( f90 ) * x5 ) / ( 1.0 - x5 );
}
#ifdef USE_DIFFUSE_ROUGHNESS
	const float EON_EPSILON = 1e-7;
	float FON_DirectionalAlbedo( const in float mu, const in float roughness, const in float A ) {
		float muComp = 1.0 - mu;
		float gOverPi = muComp * ( 0.0571085289 + muComp * ( 0.491881867 + muComp * ( - 0.332181442 + muComp * 0.0714429953 ) ) );
		return A * ( 1.0 + roughness * gOverPi );
	}
	vec3 BRDF_EON( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 diffuseColor, const in float roughness ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return BRDF_Lambert( rho );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float s = dot( lightDir, viewDir ) - dotNL * dotNV;
		float sOverT = ( s > 0.0 ) ? s / max( max( dotNL, dotNV ), EON_EPSILON ) : s;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		vec3 singleScatter = rho * RECIPROCAL_PI * A * ( 1.0 + roughness * sOverT );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		float albedoV = FON_DirectionalAlbedo( dotNV, roughness, A );
		float albedoL = FON_DirectionalAlbedo( dotNL, roughness, A );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		vec3 multiScatter = rhoMultiScatter * RECIPROCAL_PI
			* max( EON_EPSILON, 1.0 - albedoV )
			* max( EON_EPSILON, 1.0 - albedoL )
			/ max( EON_EPSILON, 1.0 - averageAlbedo );
		return singleScatter + multiScatter;
	}
	vec3 EON_DirectionalAlbedo( const in vec3 diffuseColor, const in float roughness, const in float dotNV ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return rho;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		float directionalAlbedo = FON_DirectionalAlbedo( dotNV, roughness, A );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		return rho * directionalAlbedo + rhoMultiScatter * ( 1.0 - directionalAlbedo );
	}
#endif
float V_GGX_SmithCorrelated( const in float alpha, const in float dotNL, const in float dotNV ) {
	float a2 = pow2( alpha );
	float gv = dotNL * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNV ) );
	float gl = dotNV * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNL ) );
	return 0.5 / max( gv + gl, EPSILON );
}
float D_GGX( const in float alpha, const in float dotNH ) {
	float a2 = pow2( alpha );
	float denom = pow2( dotNH ) * ( a2 - 1.0 ) + 1.0;
	return RECIPROCAL_PI * a2 / pow2( denom );
}
#ifdef USE_ANISOTROPY
	float V_GGX_SmithCorrelated_Anisotropic( const in float alphaT, const in float alphaB, const in float dotTV, const in float dotBV, const in float dotTL, const in float dotBL, const in float dotNV, const in float dotNL ) {
		float gv = dotNL * length( vec3( alphaT * dotTV, alphaB * dotBV, dotNV ) );
		float gl = dotNV * length( vec3( alphaT * dotTL, alphaB * dotBL, dotNL ) );
		return 0.5 / max( gv + gl, EPSILON );
	}
	float D_GGX_Anisotropic( const in float alphaT, const in float alphaB, const in float dotNH, const in float dotTH, const in float dotBH ) {
		float a2 = alphaT * alphaB;
		highp vec3 v = vec3( alphaB * dotTH, alphaT * dotBH, a2 * dotNH );
		highp float v2 = dot( v, v );
		float w2 = a2 / v2;
		return RECIPROCAL_PI * a2 * pow2 ( w2 );
	}
#endif
#ifdef USE_CLEARCOAT
	vec3 BRDF_GGX_Clearcoat( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material) {
		vec3 f0 = material.clearcoatF0;
		float f90 = material.clearcoatF90;
		float roughness = max( material.clearcoatRoughness, 0.045 );
		float alpha = pow2( roughness );
		vec3 halfDir = normalize( lightDir + viewDir );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float dotNH = saturate( dot( normal, halfDir ) );
		float dotVH = saturate( dot( viewDir, halfDir ) );
		vec3 F = F_Schlick( f0, f90, dotVH );
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
		return F * ( V * D );
	}
#endif
vec3 BRDF_GGX( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material ) {
	vec3 f0 = material.specularColorBlended;
	float f90 = material.specularF90;
	float roughness = max( material.roughness, 0.045 );
	float alpha = pow2( roughness );
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( f0, f90, dotVH );
	#ifdef USE_IRIDESCENCE
		F = mix( F, material.iridescenceFresnel, material.iridescence );
	#endif
	#ifdef USE_ANISOTROPY
		float dotTL = dot( material.anisotropyT, lightDir );
		float dotTV = dot( material.anisotropyT, viewDir );
		float dotTH = dot( material.anisotropyT, halfDir );
		float dotBL = dot( material.anisotropyB, lightDir );
		float dotBV = dot( material.anisotropyB, viewDir );
		float dotBH = dot( material.anisotropyB, halfDir );
		float alphaT = max( material.alphaT, alpha );
		float V = V_GGX_SmithCorrelated_Anisotropic( alphaT, alpha, dotTV, dotBV, dotTL, dotBL, dotNV, dotNL );
		float D = D_GGX_Anisotropic( alphaT, alpha, dotNH, dotTH, dotBH );
	#else
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
	#endif
	return F * ( V * D );
}
vec2 LTC_Uv( const in vec3 N, const in vec3 V, const in float roughness ) {
	const float LUT_SIZE = 64.0;
	const float LUT_SCALE = ( LUT_SIZE - 1.0 ) / LUT_SIZE;
	const float LUT_BIAS = 0.5 / LUT_SIZE;
	float dotNV = saturate( dot( N, V ) );
	vec2 uv = vec2( roughness, sqrt( 1.0 - dotNV ) );
	uv = uv * LUT_SCALE + LUT_BIAS;
	return uv;
}
float LTC_ClippedSphereFormFactor( const in vec3 f ) {
	float l = length( f );
	return max( ( l * l + f.z ) / ( l + 1.0 ), 0.0 );
}
vec3 LTC_EdgeVectorFormFactor( const in vec3 v1, const in vec3 v2 ) {
	float x = dot( v1, v2 );
	float y = abs( x );
	float a = 0.8543985 + ( 0.4965155 + 0.0145206 * y ) * y;
	float b = 3.4175940 + ( 4.1616724 + y ) * y;
	float v = a / b;
	float theta_sintheta = ( x > 0.0 ) ? v : 0.5 * inversesqrt( max( 1.0 - x * x, 1e-7 ) ) - v;
	return cross( v1, v2 ) * theta_sintheta;
}
vec3 LTC_Evaluate( const in vec3 N, const in vec3 V, const in vec3 P, const in mat3 mInv, const in vec3 rectCoords[ 4 ] ) {
	vec3 v1 = rectCoords[ 1 ] - rectCoords[ 0 ];
	vec3 v2 = rectCoords[ 3 ] - rectCoords[ 0 ];
	vec3 lightNormal = cross( v1, v2 );
	if( dot( lightNormal, P - rectCoords[ 0 ] ) < 0.0 ) return vec3( 0.0 );
	vec3 T1, T2;
	T1 = normalize( V - N * dot( V, N ) );
	T2 = - cross( N, T1 );
	mat3 mat = mInv * transpose( mat3( T1, T2, N ) );
	vec3 coords[ 4 ];
	coords[ 0 ] = mat * ( rectCoords[ 0 ] - P );
	coords[ 1 ] = mat * ( rectCoords[ 1 ] - P );
	coords[ 2 ] = mat * ( rectCoords[ 2 ] - P );
	coords[ 3 ] = mat * ( rectCoords[ 3 ] - P );
	coords[ 0 ] = normalize( coords[ 0 ] );
	coords[ 1 ] = normalize( coords[ 1 ] );
	coords[ 2 ] = normalize( coords[ 2 ] );
	coords[ 3 ] = normalize( coords[ 3 ] );
	vec3 vectorFormFactor = vec3( 0.0 );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 0 ], coords[ 1 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 1 ], coords[ 2 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 2 ], coords[ 3 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 3 ], coords[ 0 ] );
	float result = LTC_ClippedSphereFormFactor( vectorFormFactor );
	return vec3( result );
}
#if defined( USE_SHEEN )
float D_Charlie( float roughness, float dotNH ) {
	float alpha = pow2( roughness );
	float invAlpha = 1.0 / alpha;
	float cos2h = dotNH * dotNH;
	float sin2h = max( 1.0 - cos2h, 0.0078125 );
	return ( 2.0 + invAlpha ) * pow( sin2h, invAlpha * 0.5 ) / ( 2.0 * PI );
}
float V_Neubelt( float dotNV, float dotNL ) {
	return saturate( 1.0 / ( 4.0 * ( dotNL + dotNV - dotNL * dotNV ) ) );
}
vec3 BRDF_Sheen( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, vec3 sheenColor, const in float sheenRoughness ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float D = D_Charlie( sheenRoughness, dotNH );
	float V = V_Neubelt( dotNV, dotNL );
	return sheenColor * ( D * V );
}
#endif
float IBLSheenBRDF( const in vec3 normal, const in vec3 viewDir, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	float r2 = roughness * roughness;
	float rInv = 1.0 / ( roughness + 0.1 );
	float a = -1.9362 + 1.0678 * roughness + 0.4573 * r2 - 0.8469 * rInv;
	float b = -0.6014 + 0.5538 * roughness - 0.4670 * r2 - 0.1255 * rInv;
	float DG = exp( a * dotNV + b );
	return saturate( DG );
}
vec3 EnvironmentBRDF( const in vec3 normal, const in vec3 viewDir, const in vec3 specularColor, const in float specularF90, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	vec2 fab = texture2D( dfgLUT, vec2( roughness, dotNV ) ).rg;
	return specularColor * fab.x + specularF90 * fab.y;
}
#ifdef USE_IRIDESCENCE
void computeMultiscatteringIridescence( const in vec2 fab, const in vec3 specularColor, const in float specularF90, const in float iridescence, const in vec3 iridescenceF0, inout vec3 singleScatter, inout vec3 multiScatter ) {
#else
void computeMultiscattering( const in vec2 fab, const in vec3 specularColor, const in float specularF90, inout vec3 singleScatter, inout vec3 multiScatter ) {
#endif
	#ifdef USE_IRIDESCENCE
		vec3 Fr = mix( specularColor, iridescenceF0, iridescence );
	#else
		vec3 Fr = specularColor;
	#endif
	vec3 FssEss = Fr * fab.x + specularF90 * fab.y;
	float Ess = fab.x + fab.y;
	float Ems = 1.0 - Ess;
	vec3 Favg = Fr + ( 1.0 - Fr ) * 0.047619;	vec3 Fms = FssEss * Favg / ( 1.0 - Ems * Favg );
	singleScatter += FssEss;
	multiScatter += Fms * Ems;
}
#if NUM_RECT_AREA_LIGHTS > 0
	void RE_Direct_RectArea_Physical( const in RectAreaLight rectAreaLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
		vec3 normal = geometryNormal;
		vec3 viewDir = geometryViewDir;
		vec3 position = geometryPosition;
		vec3 lightPos = rectAreaLight.position;
		vec3 halfWidth = rectAreaLight.halfWidth;
		vec3 halfHeight = rectAreaLight.halfHeight;
		vec3 lightColor = rectAreaLight.color;
		float roughness = material.roughness;
		vec3 rectCoords[ 4 ];
		rectCoords[ 0 ] = lightPos + halfWidth - halfHeight;		rectCoords[ 1 ] = lightPos - halfWidth - halfHeight;
		rectCoords[ 2 ] = lightPos - halfWidth + halfHeight;
		rectCoords[ 3 ] = lightPos + halfWidth + halfHeight;
		vec2 uv = LTC_Uv( normal, viewDir, roughness );
		vec4 t1 = texture2D( ltc_1, uv );
		vec4 t2 = texture2D( ltc_2, uv );
		mat3 mInv = mat3(
			vec3( t1.x, 0, t1.y ),
			vec3(    0, 1,    0 ),
			vec3( t1.z, 0, t1.w )
		);
		vec3 fresnel = ( material.specularColorBlended * t2.x + ( material.specularF90 - material.specularColorBlended ) * t2.y );
		reflectedLight.directSpecular += lightColor * fresnel * LTC_Evaluate( normal, viewDir, position, mInv, rectCoords );
		reflectedLight.directDiffuse += lightColor * material.diffuseContribution * LTC_Evaluate( normal, viewDir, position, mat3( 1.0 ), rectCoords );
		#ifdef USE_CLEARCOAT
			vec3 Ncc = geometryClearcoatNormal;
			vec2 uvClearcoat = LTC_Uv( Ncc, viewDir, material.clearcoatRoughness );
			vec4 t1Clearcoat = texture2D( ltc_1, uvClearcoat );
			vec4 t2Clearcoat = texture2D( ltc_2, uvClearcoat );
			mat3 mInvClearcoat = mat3(
				vec3( t1Clearcoat.x, 0, t1Clearcoat.y ),
				vec3(             0, 1,             0 ),
				vec3( t1Clearcoat.z, 0, t1Clearcoat.w )
			);
			vec3 fresnelClearcoat = material.clearcoatF0 * t2Clearcoat.x + ( material.clearcoatF90 - material.clearcoatF0 ) * t2Clearcoat.y;
			clearcoatSpecularDirect += lightColor * fresnelClearcoat * LTC_Evaluate( Ncc, viewDir, position, mInvClearcoat, rectCoords );
		#endif
	}
#endif
void RE_Direct_Physical( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	#ifdef USE_CLEARCOAT
		float dotNLcc = saturate( dot( geometryClearcoatNormal, directLight.direction ) );
		vec3 ccIrradiance = dotNLcc * directLight.color;
		clearcoatSpecularDirect += ccIrradiance * BRDF_GGX_Clearcoat( directLight.direction, geometryViewDir, geometryClearcoatNormal, material );
	#endif
	#ifdef USE_SHEEN
 
 		sheenSpecularDirect += irradiance * BRDF_Sheen( directLight.direction, geometryViewDir, geometryNormal, material.sheenColor, material.sheenRoughness );
 
 		float sheenAlbedoV = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
 		float sheenAlbedoL = IBLSheenBRDF( geometryNormal, directLight.direction, material.sheenRoughness );
 
 		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * max( sheenAlbedoV, sheenAlbedoL );
 
 		irradiance *= sheenEnergyComp;
 
 	#endif
	vec3 specularBRDF = BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, material );
	#ifdef USE_RETROREFLECTION
		vec3 retroViewDir = reflect( - geometryViewDir, geometryNormal );
		vec3 retroSpecularBRDF = BRDF_GGX( directLight.direction, retroViewDir, geometryNormal, material );
		specularBRDF = mix( specularBRDF, retroSpecularBRDF, saturate( material.retroreflectivity ) );
	#endif
	reflectedLight.directSpecular += irradiance * specularBRDF * material.multiScatteringCompensation;
	vec3 halfDir = normalize( directLight.direction + geometryViewDir );
	float dotVH = saturate( dot( geometryViewDir, halfDir ) );
	vec3 F = F_Schlick( material.specularColor, material.specularF90, dotVH );
	#ifdef USE_RETROREFLECTION
		vec3 retroHalfDir = normalize( directLight.direction + retroViewDir );
		float dotRetroVH = saturate( dot( retroViewDir, retroHalfDir ) );
		vec3 retroF = F_Schlick( material.specularColor, material.specularF90, dotRetroVH );
		F = mix( F, retroF, saturate( material.retroreflectivity ) );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		vec3 diffuseBRDF = BRDF_EON( directLight.direction, geometryViewDir, geometryNormal, material.diffuseColor, material.diffuseRoughness ) * ( 1.0 - material.metalness );
	#else
		vec3 diffuseBRDF = BRDF_Lambert( material.diffuseContribution );
	#endif
	reflectedLight.directDiffuse += irradiance * diffuseBRDF * ( 1.0 - F );
}
void RE_IndirectDiffuse_Physical( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 singleScattering = vec3( 0.0 );
	vec3 multiScattering = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScattering, multiScattering );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScattering, multiScattering );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuseAlbedo = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness );
		vec3 diffuse = irradiance * RECIPROCAL_PI * diffuseAlbedo * ( 1.0 - singleScattering - multiScattering );
	#else
		vec3 diffuse = irradiance * BRDF_Lambert( material.diffuseContribution ) * ( 1.0 - singleScattering - multiScattering );
	#endif
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		sheenSpecularIndirect += irradiance * material.sheenColor * sheenAlbedo * RECIPROCAL_PI;
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		diffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectDiffuse += diffuse;
}
void RE_IndirectSpecular_Physical( const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
	#ifdef USE_CLEARCOAT
		clearcoatSpecularIndirect += clearcoatRadiance * EnvironmentBRDF( geometryClearcoatNormal, geometryViewDir, material.clearcoatF0, material.clearcoatF90, material.clearcoatRoughness );
	#endif
	#ifdef USE_SHEEN
		sheenSpecularIndirect += irradiance * material.sheenColor * IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness ) * RECIPROCAL_PI;
 	#endif
	vec3 singleScatteringDielectric = vec3( 0.0 );
	vec3 multiScatteringDielectric = vec3( 0.0 );
	vec3 singleScatteringMetallic = vec3( 0.0 );
	vec3 multiScatteringMetallic = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscatteringIridescence( material.dfg, material.diffuseColor, material.specularF90, material.iridescence, material.iridescenceF0Metallic, singleScatteringMetallic, multiScatteringMetallic );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscattering( material.dfg, material.diffuseColor, material.specularF90, singleScatteringMetallic, multiScatteringMetallic );
	#endif
	vec3 singleScattering = mix( singleScatteringDielectric, singleScatteringMetallic, material.metalness );
	vec3 multiScattering = mix( multiScatteringDielectric, multiScatteringMetallic, material.metalness );
	vec3 totalScatteringDielectric = singleScatteringDielectric + multiScatteringDielectric;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuse = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness ) * ( 1.0 - totalScatteringDielectric );
	#else
		vec3 diffuse = material.diffuseContribution * ( 1.0 - totalScatteringDielectric );
	#endif
	vec3 cosineWeightedIrradiance = irradiance * RECIPROCAL_PI;
	vec3 indirectSpecular = radiance * singleScattering;
	indirectSpecular += multiScattering * cosineWeightedIrradiance;
	vec3 indirectDiffuse = diffuse * cosineWeightedIrradiance;
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		indirectSpecular *= sheenEnergyComp;
		indirectDiffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectSpecular += indirectSpecular;
	reflectedLight.indirectDiffuse += indirectDiffuse;
}
#define RE_Direct				RE_Direct_Physical
#define RE_Direct_RectArea		RE_Direct_RectArea_Physical
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Physical
#define RE_IndirectSpecular		RE_IndirectSpecular_Physical
float computeSpecularOcclusion( const in float dotNV, const in float ambientOcclusion, const in float roughness ) {
	return saturate( pow( dotNV + ambientOcclusion, exp2( - 16.0 * roughness - 1.0 ) ) - 1.0 + ambientOcclusion );
}`,Yd=`
vec3 geometryPosition = - vViewPosition;
vec3 geometryNormal = normal;
vec3 geometryViewDir = ( isOrthographic ) ? vec3( 0, 0, 1 ) : normalize( vViewPosition );
vec3 geometryClearcoatNormal = vec3( 0.0 );
#ifdef USE_CLEARCOAT
	geometryClearcoatNormal = clearcoatNormal;
#endif
#ifdef USE_IRIDESCENCE
	float dotNVi = saturate( dot( normal, geometryViewDir ) );
	if ( material.iridescenceThickness == 0.0 ) {
		material.iridescence = 0.0;
	} else {
		material.iridescence = saturate( material.iridescence );
	}
	if ( material.iridescence > 0.0 ) {
		vec3 iridescenceFresnelDielectric = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.specularColor );
		vec3 iridescenceFresnelMetallic = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.diffuseColor );
		material.iridescenceFresnel = mix( iridescenceFresnelDielectric, iridescenceFresnelMetallic, material.metalness );
		material.iridescenceF0Dielectric = Schlick_to_F0( iridescenceFresnelDielectric, 1.0, dotNVi );
		material.iridescenceF0Metallic = Schlick_to_F0( iridescenceFresnelMetallic, 1.0, dotNVi );
	}
#endif
#ifdef STANDARD
	float dotNVms = saturate( dot( geometryNormal, geometryViewDir ) );
	material.dfg = texture2D( dfgLUT, vec2( material.roughness, dotNVms ) ).rg;
	#if ( NUM_SUN_LIGHTS > 0 || NUM_DIR_LIGHTS > 0 || NUM_POINT_LIGHTS > 0 || NUM_SPOT_LIGHTS > 0 )
		float EssMs = material.dfg.x + material.dfg.y;
		material.multiScatteringCompensation = 1.0 + material.specularColorBlended * ( 1.0 / EssMs - 1.0 );
	#endif
#endif
IncidentLight directLight;
#if ( NUM_POINT_LIGHTS > 0 ) && defined( RE_Direct )
	PointLight pointLight;
	#if defined( USE_SHADOWMAP ) && NUM_POINT_LIGHT_SHADOWS > 0
	PointLightShadow pointLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHTS; i ++ ) {
		pointLight = pointLights[ i ];
		getPointLightInfo( pointLight, geometryPosition, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_POINT_LIGHT_SHADOWS ) && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
		pointLightShadow = pointLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getPointShadow( pointShadowMap[ i ], pointLightShadow.shadowMapSize, pointLightShadow.shadowIntensity, pointLightShadow.shadowBias, pointLightShadow.shadowRadius, vPointShadowCoord[ i ], pointLightShadow.shadowCameraNear, pointLightShadow.shadowCameraFar ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SPOT_LIGHTS > 0 ) && defined( RE_Direct )
	SpotLight spotLight;
	vec4 spotColor;
	vec3 spotLightCoord;
	bool inSpotLightMap;
	#if defined( USE_SHADOWMAP ) && NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHTS; i ++ ) {
		spotLight = spotLights[ i ];
		getSpotLightInfo( spotLight, geometryPosition, directLight );
		#if ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#define SPOT_LIGHT_MAP_INDEX UNROLLED_LOOP_INDEX
		#elif ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		#define SPOT_LIGHT_MAP_INDEX NUM_SPOT_LIGHT_MAPS
		#else
		#define SPOT_LIGHT_MAP_INDEX ( UNROLLED_LOOP_INDEX - NUM_SPOT_LIGHT_SHADOWS + NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#endif
		#if ( SPOT_LIGHT_MAP_INDEX < NUM_SPOT_LIGHT_MAPS )
			spotLightCoord = vSpotLightCoord[ i ].xyz / vSpotLightCoord[ i ].w;
			inSpotLightMap = all( lessThan( abs( spotLightCoord * 2. - 1. ), vec3( 1.0 ) ) );
			spotColor = texture2D( spotLightMap[ SPOT_LIGHT_MAP_INDEX ], spotLightCoord.xy );
			directLight.color = inSpotLightMap ? directLight.color * spotColor.rgb : directLight.color;
		#endif
		#undef SPOT_LIGHT_MAP_INDEX
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		spotLightShadow = spotLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( spotShadowMap[ i ], spotLightShadow.shadowMapSize, spotLightShadow.shadowIntensity, spotLightShadow.shadowBias, spotLightShadow.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SUN_LIGHTS > 0 ) && defined( RE_Direct )
	SunLight sunLight;
	#if defined( USE_SHADOWMAP ) && NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHTS; i ++ ) {
		sunLight = sunLights[ i ];
		getSunLightInfo( sunLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SUN_LIGHT_SHADOWS )
		sunLightShadow = sunLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getSunShadow( sunShadowMap[ i ], sunLightShadow, UNROLLED_LOOP_INDEX ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_DIR_LIGHTS > 0 ) && defined( RE_Direct )
	DirectionalLight directionalLight;
	#if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHTS; i ++ ) {
		directionalLight = directionalLights[ i ];
		getDirectionalLightInfo( directionalLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_DIR_LIGHT_SHADOWS )
		directionalLightShadow = directionalLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap[ i ], directionalLightShadow.shadowMapSize, directionalLightShadow.shadowIntensity, directionalLightShadow.shadowBias, directionalLightShadow.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_RECT_AREA_LIGHTS > 0 ) && defined( RE_Direct_RectArea )
	RectAreaLight rectAreaLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_RECT_AREA_LIGHTS; i ++ ) {
		rectAreaLight = rectAreaLights[ i ];
		RE_Direct_RectArea( rectAreaLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if defined( RE_IndirectDiffuse )
	vec3 iblIrradiance = vec3( 0.0 );
	vec3 irradiance = getAmbientLightIrradiance( ambientLightColor );
	#if defined( USE_LIGHT_PROBES )
		irradiance += getLightProbeIrradiance( lightProbe, geometryNormal );
	#endif
	#if ( NUM_HEMI_LIGHTS > 0 )
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_HEMI_LIGHTS; i ++ ) {
			irradiance += getHemisphereLightIrradiance( hemisphereLights[ i ], geometryNormal );
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_LIGHT_PROBE_GRIDS > 0
		vec3 probeWorldPos = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
		vec3 probeWorldNormal = transformNormalByInverseViewMatrix( geometryNormal, viewMatrix );
		int probeGrid = - 1;
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( isInsideLightProbeGrid( probeWorldPos, probeWorldNormal, probesMin[ i ], probesMax[ i ], probesResolution[ i ] ) ) probeGrid = UNROLLED_LOOP_INDEX;
		}
		#pragma unroll_loop_end
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( probeGrid == UNROLLED_LOOP_INDEX ) irradiance += getLightProbeGridIrradiance( probesSH[ i ], probesMin[ i ], probesMax[ i ], probesResolution[ i ], probeWorldPos, probeWorldNormal );
		}
		#pragma unroll_loop_end
	#endif
#endif
#if defined( RE_IndirectSpecular )
	vec3 radiance = vec3( 0.0 );
	vec3 clearcoatRadiance = vec3( 0.0 );
#endif`,Zd=`#if defined( RE_IndirectDiffuse )
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		vec3 lightMapIrradiance = lightMapTexel.rgb * lightMapIntensity;
		irradiance += lightMapIrradiance;
	#endif
	#if defined( USE_ENVMAP ) && defined( ENVMAP_TYPE_PMREM )
		#if defined( STANDARD ) || defined( LAMBERT ) || defined( PHONG )
			iblIrradiance += getIBLIrradiance( geometryNormal );
		#endif
	#endif
#endif
#if defined( USE_ENVMAP ) && defined( RE_IndirectSpecular )
	#ifdef USE_ANISOTROPY
		vec3 iblRadiance = getIBLAnisotropyRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
	#else
		vec3 iblRadiance = getIBLRadiance( geometryViewDir, geometryNormal, material.roughness );
	#endif
	#ifdef USE_RETROREFLECTION
		#ifdef USE_ANISOTROPY
			vec3 retroIBLRadiance = getIBLAnisotropyRetroRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
		#else
			vec3 retroIBLRadiance = getIBLRetroRadiance( geometryViewDir, geometryNormal, material.roughness );
		#endif
		iblRadiance = mix( iblRadiance, retroIBLRadiance, saturate( material.retroreflectivity ) );
	#endif
	radiance += iblRadiance;
	#ifdef USE_CLEARCOAT
		clearcoatRadiance += getIBLRadiance( geometryViewDir, geometryClearcoatNormal, material.clearcoatRoughness );
	#endif
#endif`,Jd=`#if defined( RE_IndirectDiffuse )
	#if defined( LAMBERT ) || defined( PHONG )
		irradiance += iblIrradiance;
	#endif
	RE_IndirectDiffuse( irradiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif
#if defined( RE_IndirectSpecular )
	RE_IndirectSpecular( radiance, iblIrradiance, clearcoatRadiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif`,$d=`#if NUM_LIGHT_PROBE_GRIDS > 0
uniform highp sampler3D probesSH[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMin[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMax[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesResolution[ NUM_LIGHT_PROBE_GRIDS ];
bool isInsideLightProbeGrid( vec3 worldPos, vec3 worldNormal, vec3 probesMin, vec3 probesMax, vec3 probesResolution ) {
	vec3 spacing = ( probesMax - probesMin ) / probesResolution;
	vec3 samplePos = worldPos + worldNormal * spacing * 0.5;
	vec3 margin = spacing * 0.01;
	return all( greaterThanEqual( samplePos, probesMin - margin ) ) && all( lessThanEqual( samplePos, probesMax + margin ) );
}
vec3 getLightProbeGridIrradiance( highp sampler3D probesSH, vec3 probesMin, vec3 probesMax, vec3 probesResolution, vec3 worldPos, vec3 worldNormal ) {
	vec3 res = probesResolution;
	vec3 gridRange = probesMax - probesMin;
	vec3 probeSpacing = gridRange / res;
	vec3 samplePos = worldPos + worldNormal * probeSpacing * 0.5;
	vec3 uvw = clamp( ( samplePos - probesMin ) / gridRange, 0.5 / res, 1.0 - 0.5 / res );
	float nz          = res.z;
	float paddedSlices = nz + 2.0;
	float atlasDepth  = 7.0 * paddedSlices;
	float uvZBase     = uvw.z * nz + 1.0;
	vec4 s0 = texture( probesSH, vec3( uvw.xy, ( uvZBase                       ) / atlasDepth ) );
	vec4 s1 = texture( probesSH, vec3( uvw.xy, ( uvZBase +       paddedSlices   ) / atlasDepth ) );
	vec4 s2 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 2.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s3 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 3.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s4 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 4.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s5 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 5.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s6 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 6.0 * paddedSlices   ) / atlasDepth ) );
	vec3 c0 = s0.xyz;
	vec3 c1 = vec3( s0.w, s1.xy );
	vec3 c2 = vec3( s1.zw, s2.x );
	vec3 c3 = s2.yzw;
	vec3 c4 = s3.xyz;
	vec3 c5 = vec3( s3.w, s4.xy );
	vec3 c6 = vec3( s4.zw, s5.x );
	vec3 c7 = s5.yzw;
	vec3 c8 = s6.xyz;
	float x = worldNormal.x, y = worldNormal.y, z = worldNormal.z;
	vec3 result = c0 * 0.886227;
	result += c1 * 2.0 * 0.511664 * y;
	result += c2 * 2.0 * 0.511664 * z;
	result += c3 * 2.0 * 0.511664 * x;
	result += c4 * 2.0 * 0.429043 * x * y;
	result += c5 * 2.0 * 0.429043 * y * z;
	result += c6 * ( 0.743125 * z * z - 0.247708 );
	result += c7 * 2.0 * 0.429043 * x * z;
	result += c8 * 0.429043 * ( x * x - y * y );
	return max( result, vec3( 0.0 ) );
}
#endif`,Kd=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	gl_FragDepth = vIsPerspective == 0.0 ? gl_FragCoord.z : log2( vFragDepth ) * logDepthBufFC * 0.5;
#endif`,Qd=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	uniform float logDepthBufFC;
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,jd=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,tp=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	vFragDepth = 1.0 + gl_Position.w;
	vIsPerspective = float( isPerspectiveMatrix( projectionMatrix ) );
#endif`,ep=`#ifdef USE_MAP
	vec4 sampledDiffuseColor = texture2D( map, vMapUv );
	#ifdef DECODE_VIDEO_TEXTURE
		sampledDiffuseColor = sRGBTransferEOTF( sampledDiffuseColor );
	#endif
	diffuseColor *= sampledDiffuseColor;
#endif`,np=`#ifdef USE_MAP
	uniform sampler2D map;
#endif`,ip=`#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
	#if defined( USE_POINTS_UV )
		vec2 uv = vUv;
	#else
		vec2 uv = ( uvTransform * vec3( gl_PointCoord.x, 1.0 - gl_PointCoord.y, 1 ) ).xy;
	#endif
#endif
#ifdef USE_MAP
	diffuseColor *= texture2D( map, uv );
#endif
#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, uv ).g;
#endif`,rp=`#if defined( USE_POINTS_UV )
	varying vec2 vUv;
#else
	#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
		uniform mat3 uvTransform;
	#endif
#endif
#ifdef USE_MAP
	uniform sampler2D map;
#endif
#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,sp=`float metalnessFactor = metalness;
#ifdef USE_METALNESSMAP
	vec4 texelMetalness = texture2D( metalnessMap, vMetalnessMapUv );
	metalnessFactor *= texelMetalness.b;
#endif`,ap=`#ifdef USE_METALNESSMAP
	uniform sampler2D metalnessMap;
#endif`,op=`#ifdef USE_INSTANCING_MORPH
	float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	float morphTargetBaseInfluence = texelFetch( morphTexture, ivec2( 0, gl_InstanceID ), 0 ).r;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		morphTargetInfluences[i] =  texelFetch( morphTexture, ivec2( i + 1, gl_InstanceID ), 0 ).r;
	}
#endif`,lp=`#if defined( USE_MORPHCOLORS )
	#if defined( USE_COLOR_ALPHA )
		vColor *= morphTargetBaseInfluence;
	#elif defined( USE_COLOR )
		vColor.rgb *= morphTargetBaseInfluence;
	#endif
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		#if defined( USE_COLOR_ALPHA )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor += getMorph( gl_VertexID, i, 2 ) * morphTargetInfluences[ i ];
		#elif defined( USE_COLOR )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor.rgb += getMorph( gl_VertexID, i, 2 ).rgb * morphTargetInfluences[ i ];
		#endif
	}
#endif`,cp=`#ifdef USE_MORPHNORMALS
	objectNormal *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) objectNormal += getMorph( gl_VertexID, i, 1 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,hp=`#ifdef USE_MORPHTARGETS
	#ifndef USE_INSTANCING_MORPH
		uniform float morphTargetBaseInfluence;
		uniform float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	#endif
	uniform sampler2DArray morphTargetsTexture;
	uniform ivec2 morphTargetsTextureSize;
	vec4 getMorph( const in int vertexIndex, const in int morphTargetIndex, const in int offset ) {
		int texelIndex = vertexIndex * MORPHTARGETS_TEXTURE_STRIDE + offset;
		int y = texelIndex / morphTargetsTextureSize.x;
		int x = texelIndex - y * morphTargetsTextureSize.x;
		ivec3 morphUV = ivec3( x, y, morphTargetIndex );
		return texelFetch( morphTargetsTexture, morphUV, 0 );
	}
#endif`,up=`#ifdef USE_MORPHTARGETS
	transformed *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) transformed += getMorph( gl_VertexID, i, 0 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,fp=`float faceDirection = gl_FrontFacing ? 1.0 : - 1.0;
#ifdef FLAT_SHADED
	vec3 fdx = dFdx( vViewPosition );
	vec3 fdy = dFdy( vViewPosition );
	vec3 normal = normalize( cross( fdx, fdy ) );
#else
	vec3 normal = normalize( vNormal );
	#ifdef DOUBLE_SIDED
		normal *= faceDirection;
	#endif
#endif
#if defined( USE_NORMALMAP_TANGENTSPACE ) || defined( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY )
	#ifdef USE_TANGENT
		mat3 tbn = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn = getTangentFrame( - vViewPosition, normal,
		#if defined( USE_NORMALMAP )
			vNormalMapUv
		#elif defined( USE_CLEARCOAT_NORMALMAP )
			vClearcoatNormalMapUv
		#else
			vUv
		#endif
		);
	#endif
	#ifdef DOUBLE_SIDED
		tbn[0] *= faceDirection;
		tbn[1] *= faceDirection;
	#endif
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	#ifdef USE_TANGENT
		mat3 tbn2 = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn2 = getTangentFrame( - vViewPosition, normal, vClearcoatNormalMapUv );
	#endif
	#ifdef DOUBLE_SIDED
		tbn2[0] *= faceDirection;
		tbn2[1] *= faceDirection;
	#endif
#endif
vec3 nonPerturbedNormal = normal;`,dp=`#ifdef USE_NORMALMAP_OBJECTSPACE
	normal = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#ifdef FLIP_SIDED
		normal = - normal;
	#endif
	#ifdef DOUBLE_SIDED
		normal = normal * faceDirection;
	#endif
	normal = normalize( normalMatrix * normal );
#elif defined( USE_NORMALMAP_TANGENTSPACE )
	vec3 mapN = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#if defined( USE_PACKED_NORMALMAP )
		mapN = vec3( mapN.xy, sqrt( saturate( 1.0 - dot( mapN.xy, mapN.xy ) ) ) );
	#endif
	mapN.xy *= normalScale;
	normal = normalize( tbn * mapN );
#elif defined( USE_BUMPMAP )
	normal = perturbNormalArb( - vViewPosition, normal, dHdxy_fwd(), faceDirection );
#endif`,pp=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,mp=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,gp=`#ifndef FLAT_SHADED
	vNormal = normalize( transformedNormal );
	#ifdef USE_TANGENT
		vTangent = normalize( transformedTangent );
		vBitangent = normalize( cross( vNormal, vTangent ) * tangent.w );
		#ifdef FLIP_SIDED
			vBitangent = - vBitangent;
		#endif
	#endif
#endif`,_p=`#ifdef USE_NORMALMAP
	uniform sampler2D normalMap;
	uniform vec2 normalScale;
#endif
#ifdef USE_NORMALMAP_OBJECTSPACE
	uniform mat3 normalMatrix;
#endif
#if ! defined ( USE_TANGENT ) && ( defined ( USE_NORMALMAP_TANGENTSPACE ) || defined ( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY ) )
	mat3 getTangentFrame( vec3 eye_pos, vec3 surf_norm, vec2 uv ) {
		vec3 q0 = dFdx( eye_pos.xyz );
		vec3 q1 = dFdy( eye_pos.xyz );
		vec2 st0 = dFdx( uv.st );
		vec2 st1 = dFdy( uv.st );
		vec3 N = surf_norm;
		vec3 q1perp = cross( q1, N );
		vec3 q0perp = cross( N, q0 );
		vec3 T = q1perp * st0.x + q0perp * st1.x;
		vec3 B = q1perp * st0.y + q0perp * st1.y;
		float det = max( dot( T, T ), dot( B, B ) );
		float scale = ( det == 0.0 ) ? 0.0 : inversesqrt( det );
		return mat3( T * scale, B * scale, N );
	}
#endif`,xp=`#ifdef USE_CLEARCOAT
	vec3 clearcoatNormal = nonPerturbedNormal;
#endif`,vp=`#ifdef USE_CLEARCOAT_NORMALMAP
	vec3 clearcoatMapN = texture2D( clearcoatNormalMap, vClearcoatNormalMapUv ).xyz * 2.0 - 1.0;
	clearcoatMapN.xy *= clearcoatNormalScale;
	clearcoatNormal = normalize( tbn2 * clearcoatMapN );
#endif`,yp=`#ifdef USE_CLEARCOATMAP
	uniform sampler2D clearcoatMap;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform sampler2D clearcoatNormalMap;
	uniform vec2 clearcoatNormalScale;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform sampler2D clearcoatRoughnessMap;
#endif`,Sp=`#ifdef USE_IRIDESCENCEMAP
	uniform sampler2D iridescenceMap;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform sampler2D iridescenceThicknessMap;
#endif`,Mp=`#ifdef OPAQUE
diffuseColor.a = 1.0;
#endif
#ifdef USE_TRANSMISSION
diffuseColor.a *= material.transmissionAlpha;
#endif
gl_FragColor = vec4( outgoingLight, diffuseColor.a );`,bp=`vec3 packNormalToRGB( const in vec3 normal ) {
	return normalize( normal ) * 0.5 + 0.5;
}
vec3 unpackRGBToNormal( const in vec3 rgb ) {
	return 2.0 * rgb.xyz - 1.0;
}
const float PackUpscale = 256. / 255.;const float UnpackDownscale = 255. / 256.;const float ShiftRight8 = 1. / 256.;
const float Inv255 = 1. / 255.;
const vec4 PackFactors = vec4( 1.0, 256.0, 256.0 * 256.0, 256.0 * 256.0 * 256.0 );
const vec2 UnpackFactors2 = vec2( UnpackDownscale, 1.0 / PackFactors.g );
const vec3 UnpackFactors3 = vec3( UnpackDownscale / PackFactors.rg, 1.0 / PackFactors.b );
const vec4 UnpackFactors4 = vec4( UnpackDownscale / PackFactors.rgb, 1.0 / PackFactors.a );
vec4 packDepthToRGBA( const in float v ) {
	if( v <= 0.0 )
		return vec4( 0., 0., 0., 0. );
	if( v >= 1.0 )
		return vec4( 1., 1., 1., 1. );
	float vuf;
	float af = modf( v * PackFactors.a, vuf );
	float bf = modf( vuf * ShiftRight8, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec4( vuf * Inv255, gf * PackUpscale, bf * PackUpscale, af );
}
vec3 packDepthToRGB( const in float v ) {
	if( v <= 0.0 )
		return vec3( 0., 0., 0. );
	if( v >= 1.0 )
		return vec3( 1., 1., 1. );
	float vuf;
	float bf = modf( v * PackFactors.b, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec3( vuf * Inv255, gf * PackUpscale, bf );
}
vec2 packDepthToRG( const in float v ) {
	if( v <= 0.0 )
		return vec2( 0., 0. );
	if( v >= 1.0 )
		return vec2( 1., 1. );
	float vuf;
	float gf = modf( v * 256., vuf );
	return vec2( vuf * Inv255, gf );
}
float unpackRGBAToDepth( const in vec4 v ) {
	return dot( v, UnpackFactors4 );
}
float unpackRGBToDepth( const in vec3 v ) {
	return dot( v, UnpackFactors3 );
}
float unpackRGToDepth( const in vec2 v ) {
	return v.r * UnpackFactors2.r + v.g * UnpackFactors2.g;
}
vec4 pack2HalfToRGBA( const in vec2 v ) {
	vec4 r = vec4( v.x, fract( v.x * 255.0 ), v.y, fract( v.y * 255.0 ) );
	return vec4( r.x - r.y / 255.0, r.y, r.z - r.w / 255.0, r.w );
}
vec2 unpackRGBATo2Half( const in vec4 v ) {
	return vec2( v.x + ( v.y / 255.0 ), v.z + ( v.w / 255.0 ) );
}
float viewZToOrthographicDepth( const in float viewZ, const in float near, const in float far ) {
	return ( viewZ + near ) / ( near - far );
}
float orthographicDepthToViewZ( const in float depth, const in float near, const in float far ) {
	#ifdef USE_REVERSED_DEPTH_BUFFER
	
		return depth * ( far - near ) - far;
	#else
		return depth * ( near - far ) - near;
	#endif
}
float viewZToPerspectiveDepth( const in float viewZ, const in float near, const in float far ) {
	return ( ( near + viewZ ) * far ) / ( ( far - near ) * viewZ );
}
float perspectiveDepthToViewZ( const in float depth, const in float near, const in float far ) {
	
	#ifdef USE_REVERSED_DEPTH_BUFFER
		return ( near * far ) / ( ( near - far ) * depth - near );
	#else
		return ( near * far ) / ( ( far - near ) * depth - far );
	#endif
}`,wp=`#ifdef PREMULTIPLIED_ALPHA
	gl_FragColor.rgb *= gl_FragColor.a;
#endif`,Ep=`vec4 mvPosition = vec4( transformed, 1.0 );
#ifdef USE_BATCHING
	mvPosition = batchingMatrix * mvPosition;
#endif
#ifdef USE_INSTANCING
	mvPosition = instanceMatrix * mvPosition;
#endif
mvPosition = modelViewMatrix * mvPosition;
gl_Position = projectionMatrix * mvPosition;`,Ap=`#ifdef DITHERING
	gl_FragColor.rgb = dithering( gl_FragColor.rgb );
#endif`,Tp=`#ifdef DITHERING
	vec3 dithering( vec3 color ) {
		float grid_position = rand( gl_FragCoord.xy );
		vec3 dither_shift_RGB = vec3( 0.25 / 255.0, -0.25 / 255.0, 0.25 / 255.0 );
		dither_shift_RGB = mix( 2.0 * dither_shift_RGB, -2.0 * dither_shift_RGB, grid_position );
		return color + dither_shift_RGB;
	}
#endif`,Rp=`float roughnessFactor = roughness;
#ifdef USE_ROUGHNESSMAP
	vec4 texelRoughness = texture2D( roughnessMap, vRoughnessMapUv );
	roughnessFactor *= texelRoughness.g;
#endif`,Cp=`#ifdef USE_ROUGHNESSMAP
	uniform sampler2D roughnessMap;
#endif`,Ip=`#if NUM_SPOT_LIGHT_COORDS > 0
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#if NUM_SPOT_LIGHT_MAPS > 0
	uniform sampler2D spotLightMap[ NUM_SPOT_LIGHT_MAPS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		#define SUN_LIGHT_CASCADES 2
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#else
			uniform sampler2D sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#endif
		uniform mat4 sunShadowMatrix[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		uniform vec4 sunShadowCascade[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
		struct SunLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SunLightShadow sunLightShadows[ NUM_SUN_LIGHT_SHADOWS ];
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#else
			uniform sampler2D directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#endif
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#else
			uniform sampler2D spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#endif
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform samplerCubeShadow pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#elif defined( SHADOWMAP_TYPE_BASIC )
			uniform samplerCube pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#endif
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float interleavedGradientNoise( vec2 position ) {
			return fract( 52.9829189 * fract( dot( position, vec2( 0.06711056, 0.00583715 ) ) ) );
		}
		vec2 vogelDiskSample( int sampleIndex, int samplesCount, float phi ) {
			const float goldenAngle = 2.399963229728653;
			float r = sqrt( ( float( sampleIndex ) + 0.5 ) / float( samplesCount ) );
			float theta = float( sampleIndex ) * goldenAngle + phi;
			return vec2( cos( theta ), sin( theta ) ) * r;
		}
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float getShadow( sampler2DShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 texelSize = vec2( 1.0 ) / shadowMapSize;
				vec2 radius = shadowRadius * texelSize;
				float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
				shadow = (
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 0, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 1, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 2, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 3, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 4, 5, phi ) * radius, shadowCoord.z ) )
				) * 0.2;
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#elif defined( SHADOWMAP_TYPE_VSM )
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 distribution = texture2D( shadowMap, shadowCoord.xy ).rg;
				float mean = distribution.x;
				float variance = distribution.y * distribution.y;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					float hard_shadow = step( mean, shadowCoord.z );
				#else
					float hard_shadow = step( shadowCoord.z, mean );
				#endif
				
				if ( hard_shadow == 1.0 ) {
					shadow = 1.0;
				} else {
					variance = max( variance, 0.0000001 );
					float d = shadowCoord.z - mean;
					float p_max = variance / ( variance + d * d );
					p_max = clamp( ( p_max - 0.3 ) / 0.65, 0.0, 1.0 );
					shadow = max( hard_shadow, p_max );
				}
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#else
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				float depth = texture2D( shadowMap, shadowCoord.xy ).r;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					shadow = step( depth, shadowCoord.z );
				#else
					shadow = step( shadowCoord.z, depth );
				#endif
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#endif
	#if NUM_SUN_LIGHT_SHADOWS > 0
		float getSunShadow(
			#if defined( SHADOWMAP_TYPE_PCF )
				sampler2DShadow shadowMap,
			#else
				sampler2D shadowMap,
			#endif
			SunLightShadow sunLightShadow,
			int shadowIndex
		) {
			vec4 shadowWorldPosition = vec4( vSunShadowWorldPosition.xyz + vSunShadowWorldNormal * sunLightShadow.shadowNormalBias, 1.0 );
			float viewDepth = vSunShadowWorldPosition.w;
			int cascadeOffset = shadowIndex * SUN_LIGHT_CASCADES;
			float shadow = 1.0;
			for ( int i = SUN_LIGHT_CASCADES - 1; i >= 0; i -- ) {
				vec4 cascade = sunShadowCascade[ cascadeOffset + i ];
				if ( viewDepth >= cascade.x && viewDepth < cascade.y ) {
					float cascadeShadow = getShadow(
						shadowMap,
						sunLightShadow.shadowMapSize,
						sunLightShadow.shadowIntensity,
						sunLightShadow.shadowBias,
						sunLightShadow.shadowRadius,
						sunShadowMatrix[ cascadeOffset + i ] * shadowWorldPosition
					);
					shadow = mix( cascadeShadow, shadow, smoothstep( cascade.z, cascade.y, viewDepth ) );
				}
			}
			return shadow;
		}
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
	#if defined( SHADOWMAP_TYPE_PCF )
	float getPointShadow( samplerCubeShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 bd3D = normalize( lightToPosition );
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float lightDistance = length( lightToPosition );
			float depthRange = shadowCameraFar - shadowCameraNear;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				float depthA = - shadowCameraNear / depthRange - shadowBias;
				float depthB = shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#else
				float depthA = shadowCameraFar / depthRange + shadowBias;
				float depthB = - shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#endif
			float texelSize = shadowRadius / shadowMapSize.x;
			vec3 absDir = abs( bd3D );
			vec3 tangent = absDir.x > absDir.z ? vec3( 0.0, 1.0, 0.0 ) : vec3( 1.0, 0.0, 0.0 );
			tangent = normalize( cross( bd3D, tangent ) );
			vec3 bitangent = cross( bd3D, tangent );
			float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
			shadow = 0.0;
			for ( int i = 0; i < 5; i ++ ) {
				vec2 offset = vogelDiskSample( i, 5, phi );
				vec3 direction = bd3D + ( tangent * offset.x + bitangent * offset.y ) * texelSize;
				vec3 absDirection = abs( direction );
				float dp = depthA + depthB / max( max( absDirection.x, absDirection.y ), absDirection.z );
				shadow += texture( shadowMap, vec4( direction, dp ) );
			}
			shadow *= 0.2;
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#elif defined( SHADOWMAP_TYPE_BASIC )
	float getPointShadow( samplerCube shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float dp = ( shadowCameraFar * ( viewSpaceZ - shadowCameraNear ) ) / ( viewSpaceZ * ( shadowCameraFar - shadowCameraNear ) );
			dp += shadowBias;
			vec3 bd3D = normalize( lightToPosition );
			float depth = textureCube( shadowMap, bd3D ).r;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				depth = 1.0 - depth;
			#endif
			shadow = step( dp, depth );
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#endif
	#endif
#endif`,Pp=`#if NUM_SPOT_LIGHT_COORDS > 0
	uniform mat4 spotLightMatrix[ NUM_SPOT_LIGHT_COORDS ];
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		uniform mat4 directionalShadowMatrix[ NUM_DIR_LIGHT_SHADOWS ];
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		uniform mat4 pointShadowMatrix[ NUM_POINT_LIGHT_SHADOWS ];
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
#endif`,Np=`#if ( defined( USE_SHADOWMAP ) && ( NUM_DIR_LIGHT_SHADOWS > 0 || NUM_SUN_LIGHT_SHADOWS > 0 || NUM_POINT_LIGHT_SHADOWS > 0 ) ) || ( NUM_SPOT_LIGHT_COORDS > 0 )
	#ifdef HAS_NORMAL
		vec3 shadowWorldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
	#else
		vec3 shadowWorldNormal = vec3( 0.0 );
	#endif
	vec4 shadowWorldPosition;
#endif
#if defined( USE_SHADOWMAP )
	#if NUM_SUN_LIGHT_SHADOWS > 0
		vSunShadowWorldPosition = vec4( worldPosition.xyz, - mvPosition.z );
		vSunShadowWorldNormal = shadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * directionalLightShadows[ i ].shadowNormalBias, 0 );
			vDirectionalShadowCoord[ i ] = directionalShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * pointLightShadows[ i ].shadowNormalBias, 0 );
			vPointShadowCoord[ i ] = pointShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
#endif
#if NUM_SPOT_LIGHT_COORDS > 0
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_COORDS; i ++ ) {
		shadowWorldPosition = worldPosition;
		#if ( defined( USE_SHADOWMAP ) && UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
			shadowWorldPosition.xyz += shadowWorldNormal * spotLightShadows[ i ].shadowNormalBias;
		#endif
		vSpotLightCoord[ i ] = spotLightMatrix[ i ] * shadowWorldPosition;
	}
	#pragma unroll_loop_end
#endif`,Lp=`float getShadowMask() {
	float shadow = 1.0;
	#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHT_SHADOWS; i ++ ) {
		sunLight = sunLightShadows[ i ];
		shadow *= receiveShadow ? getSunShadow( sunShadowMap[ i ], sunLight, UNROLLED_LOOP_INDEX ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
		directionalLight = directionalLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( directionalShadowMap[ i ], directionalLight.shadowMapSize, directionalLight.shadowIntensity, directionalLight.shadowBias, directionalLight.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_SHADOWS; i ++ ) {
		spotLight = spotLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( spotShadowMap[ i ], spotLight.shadowMapSize, spotLight.shadowIntensity, spotLight.shadowBias, spotLight.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0 && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
	PointLightShadow pointLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
		pointLight = pointLightShadows[ i ];
		shadow *= receiveShadow ? getPointShadow( pointShadowMap[ i ], pointLight.shadowMapSize, pointLight.shadowIntensity, pointLight.shadowBias, pointLight.shadowRadius, vPointShadowCoord[ i ], pointLight.shadowCameraNear, pointLight.shadowCameraFar ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#endif
	return shadow;
}`,Dp=`#ifdef USE_SKINNING
	mat4 boneMatX = getBoneMatrix( skinIndex.x );
	mat4 boneMatY = getBoneMatrix( skinIndex.y );
	mat4 boneMatZ = getBoneMatrix( skinIndex.z );
	mat4 boneMatW = getBoneMatrix( skinIndex.w );
#endif`,Up=`#ifdef USE_SKINNING
	uniform mat4 bindMatrix;
	uniform mat4 bindMatrixInverse;
	uniform highp sampler2D boneTexture;
	mat4 getBoneMatrix( const in float i ) {
		int size = textureSize( boneTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( boneTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( boneTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( boneTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( boneTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
#endif`,Fp=`#ifdef USE_SKINNING
	vec4 skinVertex = bindMatrix * vec4( transformed, 1.0 );
	vec4 skinned = vec4( 0.0 );
	skinned += boneMatX * skinVertex * skinWeight.x;
	skinned += boneMatY * skinVertex * skinWeight.y;
	skinned += boneMatZ * skinVertex * skinWeight.z;
	skinned += boneMatW * skinVertex * skinWeight.w;
	transformed = ( bindMatrixInverse * skinned ).xyz;
#endif`,Op=`#ifdef USE_SKINNING
	mat4 skinMatrix = mat4( 0.0 );
	skinMatrix += skinWeight.x * boneMatX;
	skinMatrix += skinWeight.y * boneMatY;
	skinMatrix += skinWeight.z * boneMatZ;
	skinMatrix += skinWeight.w * boneMatW;
	skinMatrix = bindMatrixInverse * skinMatrix * bindMatrix;
	objectNormal = vec4( skinMatrix * vec4( objectNormal, 0.0 ) ).xyz;
	#ifdef USE_TANGENT
		objectTangent = vec4( skinMatrix * vec4( objectTangent, 0.0 ) ).xyz;
	#endif
#endif`,Bp=`float specularStrength;
#ifdef USE_SPECULARMAP
	vec4 texelSpecular = texture2D( specularMap, vSpecularMapUv );
	specularStrength = texelSpecular.r;
#else
	specularStrength = 1.0;
#endif`,zp=`#ifdef USE_SPECULARMAP
	uniform sampler2D specularMap;
#endif`,kp=`#if defined( TONE_MAPPING )
	gl_FragColor.rgb = toneMapping( gl_FragColor.rgb );
#endif`,Gp=`#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
uniform float toneMappingExposure;
vec3 LinearToneMapping( vec3 color ) {
	return saturate( toneMappingExposure * color );
}
vec3 ReinhardToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	return saturate( color / ( vec3( 1.0 ) + color ) );
}
vec3 CineonToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	color = max( vec3( 0.0 ), color - 0.004 );
	return pow( ( color * ( 6.2 * color + 0.5 ) ) / ( color * ( 6.2 * color + 1.7 ) + 0.06 ), vec3( 2.2 ) );
}
vec3 RRTAndODTFit( vec3 v ) {
	vec3 a = v * ( v + 0.0245786 ) - 0.000090537;
	vec3 b = v * ( 0.983729 * v + 0.4329510 ) + 0.238081;
	return a / b;
}
vec3 ACESFilmicToneMapping( vec3 color ) {
	const mat3 ACESInputMat = mat3(
		vec3( 0.59719, 0.07600, 0.02840 ),		vec3( 0.35458, 0.90834, 0.13383 ),
		vec3( 0.04823, 0.01566, 0.83777 )
	);
	const mat3 ACESOutputMat = mat3(
		vec3(  1.60475, -0.10208, -0.00327 ),		vec3( -0.53108,  1.10813, -0.07276 ),
		vec3( -0.07367, -0.00605,  1.07602 )
	);
	color *= toneMappingExposure / 0.6;
	color = ACESInputMat * color;
	color = RRTAndODTFit( color );
	color = ACESOutputMat * color;
	return saturate( color );
}
const mat3 LINEAR_REC2020_TO_LINEAR_SRGB = mat3(
	vec3( 1.6605, - 0.1246, - 0.0182 ),
	vec3( - 0.5876, 1.1329, - 0.1006 ),
	vec3( - 0.0728, - 0.0083, 1.1187 )
);
const mat3 LINEAR_SRGB_TO_LINEAR_REC2020 = mat3(
	vec3( 0.6274, 0.0691, 0.0164 ),
	vec3( 0.3293, 0.9195, 0.0880 ),
	vec3( 0.0433, 0.0113, 0.8956 )
);
vec3 agxDefaultContrastApprox( vec3 x ) {
	vec3 x2 = x * x;
	vec3 x4 = x2 * x2;
	return + 15.5 * x4 * x2
		- 40.14 * x4 * x
		+ 31.96 * x4
		- 6.868 * x2 * x
		+ 0.4298 * x2
		+ 0.1191 * x
		- 0.00232;
}
vec3 AgXToneMapping( vec3 color ) {
	const mat3 AgXInsetMatrix = mat3(
		vec3( 0.856627153315983, 0.137318972929847, 0.11189821299995 ),
		vec3( 0.0951212405381588, 0.761241990602591, 0.0767994186031903 ),
		vec3( 0.0482516061458583, 0.101439036467562, 0.811302368396859 )
	);
	const mat3 AgXOutsetMatrix = mat3(
		vec3( 1.1271005818144368, - 0.1413297634984383, - 0.14132976349843826 ),
		vec3( - 0.11060664309660323, 1.157823702216272, - 0.11060664309660294 ),
		vec3( - 0.016493938717834573, - 0.016493938717834257, 1.2519364065950405 )
	);
	const float AgxMinEv = - 12.47393;	const float AgxMaxEv = 4.026069;
	color *= toneMappingExposure;
	color = LINEAR_SRGB_TO_LINEAR_REC2020 * color;
	color = AgXInsetMatrix * color;
	color = max( color, 1e-10 );	color = log2( color );
	color = ( color - AgxMinEv ) / ( AgxMaxEv - AgxMinEv );
	color = clamp( color, 0.0, 1.0 );
	color = agxDefaultContrastApprox( color );
	color = AgXOutsetMatrix * color;
	color = pow( max( vec3( 0.0 ), color ), vec3( 2.2 ) );
	color = LINEAR_REC2020_TO_LINEAR_SRGB * color;
	color = clamp( color, 0.0, 1.0 );
	return color;
}
vec3 NeutralToneMapping( vec3 color ) {
	const float StartCompression = 0.8 - 0.04;
	const float Desaturation = 0.15;
	color *= toneMappingExposure;
	float x = min( color.r, min( color.g, color.b ) );
	float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
	color -= offset;
	float peak = max( color.r, max( color.g, color.b ) );
	if ( peak < StartCompression ) return color;
	float d = 1. - StartCompression;
	float newPeak = 1. - d * d / ( peak + d - StartCompression );
	color *= newPeak / peak;
	float g = 1. - 1. / ( Desaturation * ( peak - newPeak ) + 1. );
	return mix( color, vec3( newPeak ), g );
}
vec3 CustomToneMapping( vec3 color ) { return color; }`,Vp=`#ifdef USE_TRANSMISSION
	material.transmission = transmission;
	material.transmissionAlpha = 1.0;
	material.thickness = thickness;
	material.attenuationDistance = attenuationDistance;
	material.attenuationColor = attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		material.transmission *= texture2D( transmissionMap, vTransmissionMapUv ).r;
	#endif
	#ifdef USE_THICKNESSMAP
		material.thickness *= texture2D( thicknessMap, vThicknessMapUv ).g;
	#endif
	vec3 pos = vWorldPosition;
	vec3 v = normalize( cameraPosition - pos );
	vec3 n = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec4 transmitted = getIBLVolumeRefraction(
		n, v, material.roughness, material.diffuseContribution, material.specularColorBlended, material.specularF90,
		pos, modelMatrix, viewMatrix, projectionMatrix, material.dispersion, material.ior, material.thickness,
		material.attenuationColor, material.attenuationDistance );
	material.transmissionAlpha = mix( material.transmissionAlpha, transmitted.a, material.transmission );
	totalDiffuse = mix( totalDiffuse, transmitted.rgb, material.transmission );
#endif`,Hp=`#ifdef USE_TRANSMISSION
	uniform float transmission;
	uniform float thickness;
	uniform float attenuationDistance;
	uniform vec3 attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		uniform sampler2D transmissionMap;
	#endif
	#ifdef USE_THICKNESSMAP
		uniform sampler2D thicknessMap;
	#endif
	uniform vec2 transmissionSamplerSize;
	uniform sampler2D transmissionSamplerMap;
	uniform mat4 modelMatrix;
	uniform mat4 projectionMatrix;
	varying vec3 vWorldPosition;
	float w0( float a ) {
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - a + 3.0 ) - 3.0 ) + 1.0 );
	}
	float w1( float a ) {
		return ( 1.0 / 6.0 ) * ( a *  a * ( 3.0 * a - 6.0 ) + 4.0 );
	}
	float w2( float a ){
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - 3.0 * a + 3.0 ) + 3.0 ) + 1.0 );
	}
	float w3( float a ) {
		return ( 1.0 / 6.0 ) * ( a * a * a );
	}
	float g0( float a ) {
		return w0( a ) + w1( a );
	}
	float g1( float a ) {
		return w2( a ) + w3( a );
	}
	float h0( float a ) {
		return - 1.0 + w1( a ) / ( w0( a ) + w1( a ) );
	}
	float h1( float a ) {
		return 1.0 + w3( a ) / ( w2( a ) + w3( a ) );
	}
	vec4 bicubic( sampler2D tex, vec2 uv, vec4 texelSize, float lod ) {
		uv = uv * texelSize.zw + 0.5;
		vec2 iuv = floor( uv );
		vec2 fuv = fract( uv );
		float g0x = g0( fuv.x );
		float g1x = g1( fuv.x );
		float h0x = h0( fuv.x );
		float h1x = h1( fuv.x );
		float h0y = h0( fuv.y );
		float h1y = h1( fuv.y );
		vec2 p0 = ( vec2( iuv.x + h0x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p1 = ( vec2( iuv.x + h1x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p2 = ( vec2( iuv.x + h0x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		vec2 p3 = ( vec2( iuv.x + h1x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		return g0( fuv.y ) * ( g0x * textureLod( tex, p0, lod ) + g1x * textureLod( tex, p1, lod ) ) +
			g1( fuv.y ) * ( g0x * textureLod( tex, p2, lod ) + g1x * textureLod( tex, p3, lod ) );
	}
	vec4 textureBicubic( sampler2D sampler, vec2 uv, float lod ) {
		vec2 fLodSize = vec2( textureSize( sampler, int( lod ) ) );
		vec2 cLodSize = vec2( textureSize( sampler, int( lod + 1.0 ) ) );
		vec2 fLodSizeInv = 1.0 / fLodSize;
		vec2 cLodSizeInv = 1.0 / cLodSize;
		vec4 fSample = bicubic( sampler, uv, vec4( fLodSizeInv, fLodSize ), floor( lod ) );
		vec4 cSample = bicubic( sampler, uv, vec4( cLodSizeInv, cLodSize ), ceil( lod ) );
		return mix( fSample, cSample, fract( lod ) );
	}
	vec3 getVolumeTransmissionRay( const in vec3 n, const in vec3 v, const in float thickness, const in float ior, const in mat4 modelMatrix ) {
		vec3 refractionVector = refract( - v, normalize( n ), 1.0 / ior );
		vec3 modelScale;
		modelScale.x = length( vec3( modelMatrix[ 0 ].xyz ) );
		modelScale.y = length( vec3( modelMatrix[ 1 ].xyz ) );
		modelScale.z = length( vec3( modelMatrix[ 2 ].xyz ) );
		return normalize( refractionVector ) * thickness * modelScale;
	}
	float applyIorToRoughness( const in float roughness, const in float ior ) {
		return roughness * clamp( ior * 2.0 - 2.0, 0.0, 1.0 );
	}
	vec4 getTransmissionSample( const in vec2 fragCoord, const in float roughness, const in float ior ) {
		float lod = log2( transmissionSamplerSize.x ) * applyIorToRoughness( roughness, ior );
		return textureBicubic( transmissionSamplerMap, fragCoord.xy, lod );
	}
	vec3 volumeAttenuation( const in float transmissionDistance, const in vec3 attenuationColor, const in float attenuationDistance ) {
		if ( isinf( attenuationDistance ) ) {
			return vec3( 1.0 );
		} else {
			vec3 attenuationCoefficient = -log( attenuationColor ) / attenuationDistance;
			vec3 transmittance = exp( - attenuationCoefficient * transmissionDistance );			return transmittance;
		}
	}
	vec4 getIBLVolumeRefraction( const in vec3 n, const in vec3 v, const in float roughness, const in vec3 diffuseColor,
		const in vec3 specularColor, const in float specularF90, const in vec3 position, const in mat4 modelMatrix,
		const in mat4 viewMatrix, const in mat4 projMatrix, const in float dispersion, const in float ior, const in float thickness,
		const in vec3 attenuationColor, const in float attenuationDistance ) {
		vec4 transmittedLight;
		vec3 transmittance;
		#ifdef USE_DISPERSION
			float halfSpread = ( ior - 1.0 ) * 0.025 * dispersion;
			vec3 iors = vec3( ior - halfSpread, ior, ior + halfSpread );
			for ( int i = 0; i < 3; i ++ ) {
				vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, iors[ i ], modelMatrix );
				vec3 refractedRayExit = position + transmissionRay;
				vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
				vec2 refractionCoords = ndcPos.xy / ndcPos.w;
				refractionCoords += 1.0;
				refractionCoords /= 2.0;
				vec4 transmissionSample = getTransmissionSample( refractionCoords, roughness, iors[ i ] );
				transmittedLight[ i ] = transmissionSample[ i ];
				transmittedLight.a += transmissionSample.a;
				transmittance[ i ] = diffuseColor[ i ] * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance )[ i ];
			}
			transmittedLight.a /= 3.0;
		#else
			vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, ior, modelMatrix );
			vec3 refractedRayExit = position + transmissionRay;
			vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
			vec2 refractionCoords = ndcPos.xy / ndcPos.w;
			refractionCoords += 1.0;
			refractionCoords /= 2.0;
			transmittedLight = getTransmissionSample( refractionCoords, roughness, ior );
			transmittance = diffuseColor * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance );
		#endif
		vec3 attenuatedColor = transmittance * transmittedLight.rgb;
		vec3 F = EnvironmentBRDF( n, v, specularColor, specularF90, roughness );
		float transmittanceFactor = ( transmittance.r + transmittance.g + transmittance.b ) / 3.0;
		return vec4( ( 1.0 - F ) * attenuatedColor, 1.0 - ( 1.0 - transmittedLight.a ) * transmittanceFactor );
	}
#endif`,Wp=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_SPECULARMAP
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,Xp=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	uniform mat3 mapTransform;
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	uniform mat3 alphaMapTransform;
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	uniform mat3 lightMapTransform;
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	uniform mat3 aoMapTransform;
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	uniform mat3 bumpMapTransform;
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	uniform mat3 normalMapTransform;
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_DISPLACEMENTMAP
	uniform mat3 displacementMapTransform;
	varying vec2 vDisplacementMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	uniform mat3 emissiveMapTransform;
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	uniform mat3 metalnessMapTransform;
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	uniform mat3 roughnessMapTransform;
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	uniform mat3 diffuseRoughnessMapTransform;
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	uniform mat3 anisotropyMapTransform;
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	uniform mat3 clearcoatMapTransform;
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform mat3 clearcoatNormalMapTransform;
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform mat3 clearcoatRoughnessMapTransform;
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	uniform mat3 sheenColorMapTransform;
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	uniform mat3 sheenRoughnessMapTransform;
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	uniform mat3 iridescenceMapTransform;
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform mat3 iridescenceThicknessMapTransform;
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SPECULARMAP
	uniform mat3 specularMapTransform;
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	uniform mat3 specularColorMapTransform;
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	uniform mat3 specularIntensityMapTransform;
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,qp=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	vUv = vec3( uv, 1 ).xy;
#endif
#ifdef USE_MAP
	vMapUv = ( mapTransform * vec3( MAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ALPHAMAP
	vAlphaMapUv = ( alphaMapTransform * vec3( ALPHAMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_LIGHTMAP
	vLightMapUv = ( lightMapTransform * vec3( LIGHTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_AOMAP
	vAoMapUv = ( aoMapTransform * vec3( AOMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_BUMPMAP
	vBumpMapUv = ( bumpMapTransform * vec3( BUMPMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_NORMALMAP
	vNormalMapUv = ( normalMapTransform * vec3( NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DISPLACEMENTMAP
	vDisplacementMapUv = ( displacementMapTransform * vec3( DISPLACEMENTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_EMISSIVEMAP
	vEmissiveMapUv = ( emissiveMapTransform * vec3( EMISSIVEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_METALNESSMAP
	vMetalnessMapUv = ( metalnessMapTransform * vec3( METALNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ROUGHNESSMAP
	vRoughnessMapUv = ( roughnessMapTransform * vec3( ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	vDiffuseRoughnessMapUv = ( diffuseRoughnessMapTransform * vec3( DIFFUSE_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ANISOTROPYMAP
	vAnisotropyMapUv = ( anisotropyMapTransform * vec3( ANISOTROPYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOATMAP
	vClearcoatMapUv = ( clearcoatMapTransform * vec3( CLEARCOATMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	vClearcoatNormalMapUv = ( clearcoatNormalMapTransform * vec3( CLEARCOAT_NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	vClearcoatRoughnessMapUv = ( clearcoatRoughnessMapTransform * vec3( CLEARCOAT_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCEMAP
	vIridescenceMapUv = ( iridescenceMapTransform * vec3( IRIDESCENCEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	vIridescenceThicknessMapUv = ( iridescenceThicknessMapTransform * vec3( IRIDESCENCE_THICKNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_COLORMAP
	vSheenColorMapUv = ( sheenColorMapTransform * vec3( SHEEN_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	vSheenRoughnessMapUv = ( sheenRoughnessMapTransform * vec3( SHEEN_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULARMAP
	vSpecularMapUv = ( specularMapTransform * vec3( SPECULARMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_COLORMAP
	vSpecularColorMapUv = ( specularColorMapTransform * vec3( SPECULAR_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	vSpecularIntensityMapUv = ( specularIntensityMapTransform * vec3( SPECULAR_INTENSITYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_TRANSMISSIONMAP
	vTransmissionMapUv = ( transmissionMapTransform * vec3( TRANSMISSIONMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_THICKNESSMAP
	vThicknessMapUv = ( thicknessMapTransform * vec3( THICKNESSMAP_UV, 1 ) ).xy;
#endif`,Yp=`#if defined( USE_ENVMAP ) || defined( DISTANCE ) || defined ( USE_SHADOWMAP ) || defined ( USE_TRANSMISSION ) || NUM_SPOT_LIGHT_COORDS > 0
	vec4 worldPosition = vec4( transformed, 1.0 );
	#ifdef USE_BATCHING
		worldPosition = batchingMatrix * worldPosition;
	#endif
	#ifdef USE_INSTANCING
		worldPosition = instanceMatrix * worldPosition;
	#endif
	worldPosition = modelMatrix * worldPosition;
#endif`,Zp=`varying vec2 vUv;
uniform mat3 uvTransform;
void main() {
	vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	gl_Position = vec4( position.xy, 1.0, 1.0 );
}`,Jp=`uniform sampler2D t2D;
uniform float backgroundIntensity;
varying vec2 vUv;
void main() {
	vec4 texColor = texture2D( t2D, vUv );
	#ifdef DECODE_VIDEO_TEXTURE
		texColor = vec4( mix( pow( texColor.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), texColor.rgb * 0.0773993808, vec3( lessThanEqual( texColor.rgb, vec3( 0.04045 ) ) ) ), texColor.w );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,$p=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,Kp=`uniform float backgroundBlurriness;
uniform float backgroundIntensity;
uniform mat3 backgroundRotation;
varying vec3 vWorldDirection;
#include <envmap_common_pars_fragment>
void main() {
	#ifdef ENVMAP_TYPE_PMREM
		vec4 texColor = textureLod( envMap, backgroundRotation * vWorldDirection, roughnessToMip( backgroundBlurriness ) );
	#else
		vec4 texColor = textureCube( envMap, backgroundRotation * vWorldDirection );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,Qp=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,jp=`uniform samplerCube tCube;
uniform float tFlip;
uniform float opacity;
varying vec3 vWorldDirection;
void main() {
	vec4 texColor = textureCube( tCube, vec3( tFlip * vWorldDirection.x, vWorldDirection.yz ) );
	gl_FragColor = texColor;
	gl_FragColor.a *= opacity;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,tm=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
varying vec2 vHighPrecisionZW;
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vHighPrecisionZW = gl_Position.zw;
}`,em=`#if DEPTH_PACKING == 3200
	uniform float opacity;
#endif
#include <common>
#include <packing>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
varying vec2 vHighPrecisionZW;
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#if DEPTH_PACKING == 3200
		diffuseColor.a = opacity;
	#endif
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <logdepthbuf_fragment>
	#ifdef USE_REVERSED_DEPTH_BUFFER
		float fragCoordZ = vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ];
	#else
		float fragCoordZ = 0.5 * vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ] + 0.5;
	#endif
	#if DEPTH_PACKING == 3200
		gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );
	#elif DEPTH_PACKING == 3201
		gl_FragColor = packDepthToRGBA( fragCoordZ );
	#elif DEPTH_PACKING == 3202
		gl_FragColor = vec4( packDepthToRGB( fragCoordZ ), 1.0 );
	#elif DEPTH_PACKING == 3203
		gl_FragColor = vec4( packDepthToRG( fragCoordZ ), 0.0, 1.0 );
	#endif
}`,nm=`#define DISTANCE
varying vec3 vWorldPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <worldpos_vertex>
	#include <clipping_planes_vertex>
	vWorldPosition = worldPosition.xyz;
}`,im=`#define DISTANCE
uniform vec3 referencePosition;
uniform float nearDistance;
uniform float farDistance;
varying vec3 vWorldPosition;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	float dist = length( vWorldPosition - referencePosition );
	dist = ( dist - nearDistance ) / ( farDistance - nearDistance );
	dist = saturate( dist );
	gl_FragColor = vec4( dist, 0.0, 0.0, 1.0 );
}`,rm=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
}`,sm=`uniform sampler2D tEquirect;
varying vec3 vWorldDirection;
#include <common>
void main() {
	vec3 direction = normalize( vWorldDirection );
	vec2 sampleUV = equirectUv( direction );
	gl_FragColor = texture2D( tEquirect, sampleUV );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,am=`uniform float scale;
attribute float lineDistance;
varying float vLineDistance;
#include <common>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	vLineDistance = scale * lineDistance;
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,om=`uniform vec3 diffuse;
uniform float opacity;
uniform float dashSize;
uniform float totalSize;
varying float vLineDistance;
#include <common>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	if ( mod( vLineDistance, totalSize ) > dashSize ) {
		discard;
	}
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,lm=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#if defined ( USE_ENVMAP ) || defined ( USE_SKINNING )
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinbase_vertex>
		#include <skinnormal_vertex>
		#include <defaultnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <fog_vertex>
}`,cm=`uniform vec3 diffuse;
uniform float opacity;
#ifndef FLAT_SHADED
	varying vec3 vNormal;
#endif
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <fog_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		reflectedLight.indirectDiffuse += lightMapTexel.rgb * lightMapIntensity * RECIPROCAL_PI;
	#else
		reflectedLight.indirectDiffuse += vec3( 1.0 );
	#endif
	#include <aomap_fragment>
	reflectedLight.indirectDiffuse *= diffuseColor.rgb;
	vec3 outgoingLight = reflectedLight.indirectDiffuse;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,hm=`#define LAMBERT
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,um=`#define LAMBERT
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_lambert_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_lambert_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,fm=`#define MATCAP
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <displacementmap_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
	vViewPosition = - mvPosition.xyz;
}`,dm=`#define MATCAP
uniform vec3 diffuse;
uniform float opacity;
uniform sampler2D matcap;
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	vec3 viewDir = normalize( vViewPosition );
	vec3 x = normalize( vec3( viewDir.z, 0.0, - viewDir.x ) );
	vec3 y = cross( viewDir, x );
	vec2 uv = vec2( dot( x, normal ), dot( y, normal ) ) * 0.495 + 0.5;
	#ifdef USE_MATCAP
		vec4 matcapColor = texture2D( matcap, uv );
	#else
		vec4 matcapColor = vec4( vec3( mix( 0.2, 0.8, uv.y ) ), 1.0 );
	#endif
	vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,pm=`#define NORMAL
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	vViewPosition = - mvPosition.xyz;
#endif
}`,mm=`#define NORMAL
uniform float opacity;
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <uv_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 0.0, 0.0, 0.0, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	gl_FragColor = vec4( normalize( normal ) * 0.5 + 0.5, diffuseColor.a );
	#ifdef OPAQUE
		gl_FragColor.a = 1.0;
	#endif
}`,gm=`#define PHONG
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,_m=`#define PHONG
uniform vec3 diffuse;
uniform vec3 emissive;
uniform vec3 specular;
uniform float shininess;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_phong_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_phong_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + reflectedLight.directSpecular + reflectedLight.indirectSpecular + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,xm=`#define STANDARD
varying vec3 vViewPosition;
#ifdef USE_TRANSMISSION
	varying vec3 vWorldPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
#ifdef USE_TRANSMISSION
	vWorldPosition = worldPosition.xyz;
#endif
}`,vm=`#define STANDARD
#ifdef PHYSICAL
	#define IOR
	#define USE_SPECULAR
#endif
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float roughness;
uniform float metalness;
uniform float opacity;
#ifdef IOR
	uniform float ior;
#endif
#ifdef USE_SPECULAR
	uniform float specularIntensity;
	uniform vec3 specularColor;
	#ifdef USE_SPECULAR_COLORMAP
		uniform sampler2D specularColorMap;
	#endif
	#ifdef USE_SPECULAR_INTENSITYMAP
		uniform sampler2D specularIntensityMap;
	#endif
#endif
#ifdef USE_CLEARCOAT
	uniform float clearcoat;
	uniform float clearcoatRoughness;
#endif
#ifdef USE_DIFFUSE_ROUGHNESS
	uniform float diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		uniform sampler2D diffuseRoughnessMap;
	#endif
#endif
#ifdef USE_DISPERSION
	uniform float dispersion;
#endif
#ifdef USE_RETROREFLECTION
	uniform float retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	uniform float iridescence;
	uniform float iridescenceIOR;
	uniform float iridescenceThicknessMinimum;
	uniform float iridescenceThicknessMaximum;
#endif
#ifdef USE_SHEEN
	uniform vec3 sheenColor;
	uniform float sheenRoughness;
	#ifdef USE_SHEEN_COLORMAP
		uniform sampler2D sheenColorMap;
	#endif
	#ifdef USE_SHEEN_ROUGHNESSMAP
		uniform sampler2D sheenRoughnessMap;
	#endif
#endif
#ifdef USE_ANISOTROPY
	uniform vec2 anisotropyVector;
	#ifdef USE_ANISOTROPYMAP
		uniform sampler2D anisotropyMap;
	#endif
#endif
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <iridescence_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_physical_pars_fragment>
#include <transmission_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <clearcoat_pars_fragment>
#include <iridescence_pars_fragment>
#include <roughnessmap_pars_fragment>
#include <metalnessmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <roughnessmap_fragment>
	#include <metalnessmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <clearcoat_normal_fragment_begin>
	#include <clearcoat_normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_physical_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 totalDiffuse = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
	vec3 totalSpecular = reflectedLight.directSpecular + reflectedLight.indirectSpecular;
	#include <transmission_fragment>
	vec3 outgoingLight = totalDiffuse + totalSpecular + totalEmissiveRadiance;
	#ifdef USE_SHEEN
 
		outgoingLight = outgoingLight + sheenSpecularDirect + sheenSpecularIndirect;
 
 	#endif
	#ifdef USE_CLEARCOAT
		float dotNVcc = saturate( dot( geometryClearcoatNormal, geometryViewDir ) );
		vec3 Fcc = F_Schlick( material.clearcoatF0, material.clearcoatF90, dotNVcc );
		outgoingLight = outgoingLight * ( 1.0 - material.clearcoat * Fcc ) + ( clearcoatSpecularDirect + clearcoatSpecularIndirect ) * material.clearcoat;
	#endif
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,ym=`#define TOON
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,Sm=`#define TOON
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <gradientmap_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_toon_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_toon_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,Mm=`uniform float size;
uniform float scale;
#include <common>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
#ifdef USE_POINTS_UV
	varying vec2 vUv;
	uniform mat3 uvTransform;
#endif
void main() {
	#ifdef USE_POINTS_UV
		vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	#endif
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	gl_PointSize = size;
	#ifdef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) gl_PointSize *= ( scale / - mvPosition.z );
	#endif
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <fog_vertex>
}`,bm=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <color_pars_fragment>
#include <map_particle_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_particle_fragment>
	#include <color_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,wm=`#include <common>
#include <batching_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <shadowmap_pars_vertex>
void main() {
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,Em=`uniform vec3 color;
uniform float opacity;
#include <common>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <logdepthbuf_pars_fragment>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
void main() {
	#include <logdepthbuf_fragment>
	gl_FragColor = vec4( color, opacity * ( 1.0 - getShadowMask() ) );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,Am=`uniform float rotation;
uniform vec2 center;
#include <common>
#include <uv_pars_vertex>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	vec4 mvPosition = modelViewMatrix[ 3 ];
	vec2 scale = vec2( length( modelMatrix[ 0 ].xyz ), length( modelMatrix[ 1 ].xyz ) );
	#ifndef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) scale *= - mvPosition.z;
	#endif
	vec2 alignedPosition = ( position.xy - ( center - vec2( 0.5 ) ) ) * scale;
	vec2 rotatedPosition;
	rotatedPosition.x = cos( rotation ) * alignedPosition.x - sin( rotation ) * alignedPosition.y;
	rotatedPosition.y = sin( rotation ) * alignedPosition.x + cos( rotation ) * alignedPosition.y;
	mvPosition.xy += rotatedPosition;
	gl_Position = projectionMatrix * mvPosition;
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,Tm=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
}`,tt={alphahash_fragment:Jf,alphahash_pars_fragment:$f,alphamap_fragment:Kf,alphamap_pars_fragment:Qf,alphatest_fragment:jf,alphatest_pars_fragment:td,aomap_fragment:ed,aomap_pars_fragment:nd,batching_pars_vertex:id,batching_vertex:rd,begin_vertex:sd,beginnormal_vertex:ad,bsdfs:od,iridescence_fragment:ld,bumpmap_pars_fragment:cd,clipping_planes_fragment:hd,clipping_planes_pars_fragment:ud,clipping_planes_pars_vertex:fd,clipping_planes_vertex:dd,color_fragment:pd,color_pars_fragment:md,color_pars_vertex:gd,color_vertex:_d,common:xd,defaultnormal_vertex:vd,displacementmap_pars_vertex:yd,displacementmap_vertex:Sd,emissivemap_fragment:Md,emissivemap_pars_fragment:bd,colorspace_fragment:wd,colorspace_pars_fragment:Ed,envmap_fragment:Ad,envmap_common_pars_fragment:Td,envmap_pars_fragment:Rd,envmap_pars_vertex:Cd,envmap_physical_pars_fragment:kd,envmap_vertex:Id,fog_vertex:Pd,fog_pars_vertex:Nd,fog_fragment:Ld,fog_pars_fragment:Dd,gradientmap_pars_fragment:Ud,lightmap_pars_fragment:Fd,lights_lambert_fragment:Od,lights_lambert_pars_fragment:Bd,lights_pars_begin:zd,lights_toon_fragment:Gd,lights_toon_pars_fragment:Vd,lights_phong_fragment:Hd,lights_phong_pars_fragment:Wd,lights_physical_fragment:Xd,lights_physical_pars_fragment:qd,lights_fragment_begin:Yd,lights_fragment_maps:Zd,lights_fragment_end:Jd,lightprobes_pars_fragment:$d,logdepthbuf_fragment:Kd,logdepthbuf_pars_fragment:Qd,logdepthbuf_pars_vertex:jd,logdepthbuf_vertex:tp,map_fragment:ep,map_pars_fragment:np,map_particle_fragment:ip,map_particle_pars_fragment:rp,metalnessmap_fragment:sp,metalnessmap_pars_fragment:ap,morphinstance_vertex:op,morphcolor_vertex:lp,morphnormal_vertex:cp,morphtarget_pars_vertex:hp,morphtarget_vertex:up,normal_fragment_begin:fp,normal_fragment_maps:dp,normal_pars_fragment:pp,normal_pars_vertex:mp,normal_vertex:gp,normalmap_pars_fragment:_p,clearcoat_normal_fragment_begin:xp,clearcoat_normal_fragment_maps:vp,clearcoat_pars_fragment:yp,iridescence_pars_fragment:Sp,opaque_fragment:Mp,packing:bp,premultiplied_alpha_fragment:wp,project_vertex:Ep,dithering_fragment:Ap,dithering_pars_fragment:Tp,roughnessmap_fragment:Rp,roughnessmap_pars_fragment:Cp,shadowmap_pars_fragment:Ip,shadowmap_pars_vertex:Pp,shadowmap_vertex:Np,shadowmask_pars_fragment:Lp,skinbase_vertex:Dp,skinning_pars_vertex:Up,skinning_vertex:Fp,skinnormal_vertex:Op,specularmap_fragment:Bp,specularmap_pars_fragment:zp,tonemapping_fragment:kp,tonemapping_pars_fragment:Gp,transmission_fragment:Vp,transmission_pars_fragment:Hp,uv_pars_fragment:Wp,uv_pars_vertex:Xp,uv_vertex:qp,worldpos_vertex:Yp,background_vert:Zp,background_frag:Jp,backgroundCube_vert:$p,backgroundCube_frag:Kp,cube_vert:Qp,cube_frag:jp,depth_vert:tm,depth_frag:em,distance_vert:nm,distance_frag:im,equirect_vert:rm,equirect_frag:sm,linedashed_vert:am,linedashed_frag:om,meshbasic_vert:lm,meshbasic_frag:cm,meshlambert_vert:hm,meshlambert_frag:um,meshmatcap_vert:fm,meshmatcap_frag:dm,meshnormal_vert:pm,meshnormal_frag:mm,meshphong_vert:gm,meshphong_frag:_m,meshphysical_vert:xm,meshphysical_frag:vm,meshtoon_vert:ym,meshtoon_frag:Sm,points_vert:Mm,points_frag:bm,shadow_vert:wm,shadow_frag:Em,sprite_vert:Am,sprite_frag:Tm},z={common:{diffuse:{value:new Dt(16777215)},opacity:{value:1},map:{value:null},mapTransform:{value:new $},alphaMap:{value:null},alphaMapTransform:{value:new $},alphaTest:{value:0}},specularmap:{specularMap:{value:null},specularMapTransform:{value:new $}},envmap:{envMap:{value:null},envMapRotation:{value:new $},reflectivity:{value:1},ior:{value:1.5},refractionRatio:{value:.98},dfgLUT:{value:null}},aomap:{aoMap:{value:null},aoMapIntensity:{value:1},aoMapTransform:{value:new $}},lightmap:{lightMap:{value:null},lightMapIntensity:{value:1},lightMapTransform:{value:new $}},bumpmap:{bumpMap:{value:null},bumpMapTransform:{value:new $},bumpScale:{value:1}},normalmap:{normalMap:{value:null},normalMapTransform:{value:new $},normalScale:{value:new Ee(1,1)}},displacementmap:{displacementMap:{value:null},displacementMapTransform:{value:new $},displacementScale:{value:1},displacementBias:{value:0}},emissivemap:{emissiveMap:{value:null},emissiveMapTransform:{value:new $}},metalnessmap:{metalnessMap:{value:null},metalnessMapTransform:{value:new $}},roughnessmap:{roughnessMap:{value:null},roughnessMapTransform:{value:new $}},gradientmap:{gradientMap:{value:null}},fog:{fogDensity:{value:25e-5},fogNear:{value:1},fogFar:{value:2e3},fogColor:{value:new Dt(16777215)}},lights:{ambientLightColor:{value:[]},lightProbe:{value:[]},sunLights:{value:[],properties:{direction:{},color:{}}},sunLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},sunShadowMatrix:{value:[]},sunShadowCascade:{value:[]},directionalLights:{value:[],properties:{direction:{},color:{}}},directionalLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},directionalShadowMatrix:{value:[]},spotLights:{value:[],properties:{color:{},position:{},direction:{},distance:{},coneCos:{},penumbraCos:{},decay:{}}},spotLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},spotLightMap:{value:[]},spotLightMatrix:{value:[]},pointLights:{value:[],properties:{color:{},position:{},decay:{},distance:{}}},pointLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{},shadowCameraNear:{},shadowCameraFar:{}}},pointShadowMatrix:{value:[]},hemisphereLights:{value:[],properties:{direction:{},skyColor:{},groundColor:{}}},rectAreaLights:{value:[],properties:{color:{},position:{},width:{},height:{}}},ltc_1:{value:null},ltc_2:{value:null},probesSH:{value:[]},probesMin:{value:[]},probesMax:{value:[]},probesResolution:{value:[]}},points:{diffuse:{value:new Dt(16777215)},opacity:{value:1},size:{value:1},scale:{value:1},map:{value:null},alphaMap:{value:null},alphaMapTransform:{value:new $},alphaTest:{value:0},uvTransform:{value:new $}},sprite:{diffuse:{value:new Dt(16777215)},opacity:{value:1},center:{value:new Ee(.5,.5)},rotation:{value:0},map:{value:null},mapTransform:{value:new $},alphaMap:{value:null},alphaMapTransform:{value:new $},alphaTest:{value:0}}},cc={basic:{uniforms:te([z.common,z.specularmap,z.envmap,z.aomap,z.lightmap,z.fog]),vertexShader:tt.meshbasic_vert,fragmentShader:tt.meshbasic_frag},lambert:{uniforms:te([z.common,z.specularmap,z.envmap,z.aomap,z.lightmap,z.emissivemap,z.bumpmap,z.normalmap,z.displacementmap,z.fog,z.lights,{emissive:{value:new Dt(0)},envMapIntensity:{value:1}}]),vertexShader:tt.meshlambert_vert,fragmentShader:tt.meshlambert_frag},phong:{uniforms:te([z.common,z.specularmap,z.envmap,z.aomap,z.lightmap,z.emissivemap,z.bumpmap,z.normalmap,z.displacementmap,z.fog,z.lights,{emissive:{value:new Dt(0)},specular:{value:new Dt(1118481)},shininess:{value:30},envMapIntensity:{value:1}}]),vertexShader:tt.meshphong_vert,fragmentShader:tt.meshphong_frag},standard:{uniforms:te([z.common,z.envmap,z.aomap,z.lightmap,z.emissivemap,z.bumpmap,z.normalmap,z.displacementmap,z.roughnessmap,z.metalnessmap,z.fog,z.lights,{emissive:{value:new Dt(0)},roughness:{value:1},metalness:{value:0},envMapIntensity:{value:1}}]),vertexShader:tt.meshphysical_vert,fragmentShader:tt.meshphysical_frag},toon:{uniforms:te([z.common,z.aomap,z.lightmap,z.emissivemap,z.bumpmap,z.normalmap,z.displacementmap,z.gradientmap,z.fog,z.lights,{emissive:{value:new Dt(0)}}]),vertexShader:tt.meshtoon_vert,fragmentShader:tt.meshtoon_frag},matcap:{uniforms:te([z.common,z.bumpmap,z.normalmap,z.displacementmap,z.fog,{matcap:{value:null}}]),vertexShader:tt.meshmatcap_vert,fragmentShader:tt.meshmatcap_frag},points:{uniforms:te([z.points,z.fog]),vertexShader:tt.points_vert,fragmentShader:tt.points_frag},dashed:{uniforms:te([z.common,z.fog,{scale:{value:1},dashSize:{value:1},totalSize:{value:2}}]),vertexShader:tt.linedashed_vert,fragmentShader:tt.linedashed_frag},depth:{uniforms:te([z.common,z.displacementmap]),vertexShader:tt.depth_vert,fragmentShader:tt.depth_frag},normal:{uniforms:te([z.common,z.bumpmap,z.normalmap,z.displacementmap,{opacity:{value:1}}]),vertexShader:tt.meshnormal_vert,fragmentShader:tt.meshnormal_frag},sprite:{uniforms:te([z.sprite,z.fog]),vertexShader:tt.sprite_vert,fragmentShader:tt.sprite_frag},background:{uniforms:{uvTransform:{value:new $},t2D:{value:null},backgroundIntensity:{value:1}},vertexShader:tt.background_vert,fragmentShader:tt.background_frag},backgroundCube:{uniforms:{envMap:{value:null},backgroundBlurriness:{value:0},backgroundIntensity:{value:1},backgroundRotation:{value:new $}},vertexShader:tt.backgroundCube_vert,fragmentShader:tt.backgroundCube_frag},cube:{uniforms:{tCube:{value:null},tFlip:{value:-1},opacity:{value:1}},vertexShader:tt.cube_vert,fragmentShader:tt.cube_frag},equirect:{uniforms:{tEquirect:{value:null}},vertexShader:tt.equirect_vert,fragmentShader:tt.equirect_frag},distance:{uniforms:te([z.common,z.displacementmap,{referencePosition:{value:new Mt},nearDistance:{value:1},farDistance:{value:1e3}}]),vertexShader:tt.distance_vert,fragmentShader:tt.distance_frag},shadow:{uniforms:te([z.lights,z.fog,{color:{value:new Dt(0)},opacity:{value:1}}]),vertexShader:tt.shadow_vert,fragmentShader:tt.shadow_frag}};cc.physical={uniforms:te([cc.standard.uniforms,{clearcoat:{value:0},clearcoatMap:{value:null},clearcoatMapTransform:{value:new $},clearcoatNormalMap:{value:null},clearcoatNormalMapTransform:{value:new $},clearcoatNormalScale:{value:new Ee(1,1)},clearcoatRoughness:{value:0},clearcoatRoughnessMap:{value:null},clearcoatRoughnessMapTransform:{value:new $},diffuseRoughness:{value:0},diffuseRoughnessMap:{value:null},diffuseRoughnessMapTransform:{value:new $},dispersion:{value:0},retroreflectivity:{value:0},iridescence:{value:0},iridescenceMap:{value:null},iridescenceMapTransform:{value:new $},iridescenceIOR:{value:1.3},iridescenceThicknessMinimum:{value:100},iridescenceThicknessMaximum:{value:400},iridescenceThicknessMap:{value:null},iridescenceThicknessMapTransform:{value:new $},sheen:{value:0},sheenColor:{value:new Dt(0)},sheenColorMap:{value:null},sheenColorMapTransform:{value:new $},sheenRoughness:{value:1},sheenRoughnessMap:{value:null},sheenRoughnessMapTransform:{value:new $},transmission:{value:0},transmissionMap:{value:null},transmissionMapTransform:{value:new $},transmissionSamplerSize:{value:new Ee},transmissionSamplerMap:{value:null},thickness:{value:0},thicknessMap:{value:null},thicknessMapTransform:{value:new $},attenuationDistance:{value:0},attenuationColor:{value:new Dt(0)},specularColor:{value:new Dt(1,1,1)},specularColorMap:{value:null},specularColorMapTransform:{value:new $},specularIntensity:{value:1},specularIntensityMap:{value:null},specularIntensityMapTransform:{value:new $},anisotropyVector:{value:new Ee},anisotropyMap:{value:null},anisotropyMapTransform:{value:new $}}]),vertexShader:tt.meshphysical_vert,fragmentShader:tt.meshphysical_frag};var Rm=new $;Rm.set(-1,0,0,0,1,0,0,0,1);var lE={[za]:"LINEAR_TONE_MAPPING",[ka]:"REINHARD_TONE_MAPPING",[Ga]:"CINEON_TONE_MAPPING",[Va]:"ACES_FILMIC_TONE_MAPPING",[Wa]:"AGX_TONE_MAPPING",[Xa]:"NEUTRAL_TONE_MAPPING",[Ha]:"CUSTOM_TONE_MAPPING"};var cE=new Float32Array(16),hE=new Float32Array(9),uE=new Float32Array(4);var fE={[za]:"Linear",[ka]:"Reinhard",[Ga]:"Cineon",[Va]:"ACESFilmic",[Wa]:"AgX",[Xa]:"Neutral",[Ha]:"Custom"};var dE={[Zl]:"SHADOWMAP_TYPE_PCF",[Jl]:"SHADOWMAP_TYPE_VSM"};var pE={[tc]:"ENVMAP_MODE_REFRACTION"};var mE={[$l]:"ENVMAP_BLENDING_MULTIPLY",[Kl]:"ENVMAP_BLENDING_MIX",[Ql]:"ENVMAP_BLENDING_ADD"};var Cm=new $;Cm.set(-1,0,0,0,1,0,0,0,1);var gE=new Uint16Array([12469,15057,12620,14925,13266,14620,13807,14376,14323,13990,14545,13625,14713,13328,14840,12882,14931,12528,14996,12233,15039,11829,15066,11525,15080,11295,15085,10976,15082,10705,15073,10495,13880,14564,13898,14542,13977,14430,14158,14124,14393,13732,14556,13410,14702,12996,14814,12596,14891,12291,14937,11834,14957,11489,14958,11194,14943,10803,14921,10506,14893,10278,14858,9960,14484,14039,14487,14025,14499,13941,14524,13740,14574,13468,14654,13106,14743,12678,14818,12344,14867,11893,14889,11509,14893,11180,14881,10751,14852,10428,14812,10128,14765,9754,14712,9466,14764,13480,14764,13475,14766,13440,14766,13347,14769,13070,14786,12713,14816,12387,14844,11957,14860,11549,14868,11215,14855,10751,14825,10403,14782,10044,14729,9651,14666,9352,14599,9029,14967,12835,14966,12831,14963,12804,14954,12723,14936,12564,14917,12347,14900,11958,14886,11569,14878,11247,14859,10765,14828,10401,14784,10011,14727,9600,14660,9289,14586,8893,14508,8533,15111,12234,15110,12234,15104,12216,15092,12156,15067,12010,15028,11776,14981,11500,14942,11205,14902,10752,14861,10393,14812,9991,14752,9570,14682,9252,14603,8808,14519,8445,14431,8145,15209,11449,15208,11451,15202,11451,15190,11438,15163,11384,15117,11274,15055,10979,14994,10648,14932,10343,14871,9936,14803,9532,14729,9218,14645,8742,14556,8381,14461,8020,14365,7603,15273,10603,15272,10607,15267,10619,15256,10631,15231,10614,15182,10535,15118,10389,15042,10167,14963,9787,14883,9447,14800,9115,14710,8665,14615,8318,14514,7911,14411,7507,14279,7198,15314,9675,15313,9683,15309,9712,15298,9759,15277,9797,15229,9773,15166,9668,15084,9487,14995,9274,14898,8910,14800,8539,14697,8234,14590,7790,14479,7409,14367,7067,14178,6621,15337,8619,15337,8631,15333,8677,15325,8769,15305,8871,15264,8940,15202,8909,15119,8775,15022,8565,14916,8328,14804,8009,14688,7614,14569,7287,14448,6888,14321,6483,14088,6171,15350,7402,15350,7419,15347,7480,15340,7613,15322,7804,15287,7973,15229,8057,15148,8012,15046,7846,14933,7611,14810,7357,14682,7069,14552,6656,14421,6316,14251,5948,14007,5528,15356,5942,15356,5977,15353,6119,15348,6294,15332,6551,15302,6824,15249,7044,15171,7122,15070,7050,14949,6861,14818,6611,14679,6349,14538,6067,14398,5651,14189,5311,13935,4958,15359,4123,15359,4153,15356,4296,15353,4646,15338,5160,15311,5508,15263,5829,15188,6042,15088,6094,14966,6001,14826,5796,14678,5543,14527,5287,14377,4985,14133,4586,13869,4257,15360,1563,15360,1642,15358,2076,15354,2636,15341,3350,15317,4019,15273,4429,15203,4732,15105,4911,14981,4932,14836,4818,14679,4621,14517,4386,14359,4156,14083,3795,13808,3437,15360,122,15360,137,15358,285,15355,636,15344,1274,15322,2177,15281,2765,15215,3223,15120,3451,14995,3569,14846,3567,14681,3466,14511,3305,14344,3121,14037,2800,13753,2467,15360,0,15360,1,15359,21,15355,89,15346,253,15325,479,15287,796,15225,1148,15133,1492,15008,1749,14856,1882,14685,1886,14506,1783,14324,1608,13996,1398,13702,1183]);var Tc=1;var Rc=3;var no=0,io=1,ro=2,so=3,ao=4,oo=5,lo=6,co=7,Cc=0,Ic=1,Pc=2;var wo=1,Eo=2,Ao=3,To=4,Ro=5,Co=6,Io=7;var Po=300;var Nc=302;var ho=1e3,zi=1001,uo=1002;var Lc=1006;var Dc=1008;var Uc=1009;var Fc=1023;var Vi=2300,Kr=2301,Zr=2302,fo=2303,po=2400,mo=2401,go=2402;var No="",ge="srgb",_o="srgb-linear",xo="linear",Jr="srgb";var li=2e3,vo=2001;function Im(n){return ArrayBuffer.isView(n)&&!(n instanceof DataView)}function yo(n){return document.createElementNS("http://www.w3.org/1999/xhtml",n)}var hc={},Qr=null;function Oc(n){let t=n[0];if(typeof t=="string"&&t.startsWith("TSL:")){let e=n[1];e&&e.isStackTrace?n[0]+=" "+e.getLocation():n[1]='Stack trace not available. Enable "THREE.Node.captureStackTrace" to capture stack traces.'}return n}function Ht(...n){n=Oc(n);let t="THREE."+n.shift();if(Qr)Qr("warn",t,...n);else{let e=n[0];e&&e.isStackTrace?console.warn(e.getError(t)):console.warn(t,...n)}}function Ut(...n){n=Oc(n);let t="THREE."+n.shift();if(Qr)Qr("error",t,...n);else{let e=n[0];e&&e.isStackTrace?console.error(e.getError(t)):console.error(t,...n)}}function $r(...n){let t=n.join(" ");t in hc||(hc[t]=!0,Ht(...n))}var Pm={[no]:no,[ro]:lo,[ao]:ao,[so]:oo,[io]:io,[lo]:ro,[co]:co,[oo]:so},Hi=class{addEventListener(t,e){this._listeners===void 0&&(this._listeners={});let i=this._listeners;i[t]===void 0&&(i[t]=[]),i[t].indexOf(e)===-1&&i[t].push(e)}hasEventListener(t,e){let i=this._listeners;return i===void 0?!1:i[t]!==void 0&&i[t].indexOf(e)!==-1}removeEventListener(t,e){let i=this._listeners;if(i===void 0)return;let r=i[t];if(r!==void 0){let s=r.indexOf(e);s!==-1&&r.splice(s,1)}}dispatchEvent(t){let e=this._listeners;if(e===void 0)return;let i=e[t.type];if(i!==void 0){t.target=this;let r=i.slice(0);for(let s=0,a=r.length;s<a;s++)r[s].call(this,t);t.target=null}}},Kt=["00","01","02","03","04","05","06","07","08","09","0a","0b","0c","0d","0e","0f","10","11","12","13","14","15","16","17","18","19","1a","1b","1c","1d","1e","1f","20","21","22","23","24","25","26","27","28","29","2a","2b","2c","2d","2e","2f","30","31","32","33","34","35","36","37","38","39","3a","3b","3c","3d","3e","3f","40","41","42","43","44","45","46","47","48","49","4a","4b","4c","4d","4e","4f","50","51","52","53","54","55","56","57","58","59","5a","5b","5c","5d","5e","5f","60","61","62","63","64","65","66","67","68","69","6a","6b","6c","6d","6e","6f","70","71","72","73","74","75","76","77","78","79","7a","7b","7c","7d","7e","7f","80","81","82","83","84","85","86","87","88","89","8a","8b","8c","8d","8e","8f","90","91","92","93","94","95","96","97","98","99","9a","9b","9c","9d","9e","9f","a0","a1","a2","a3","a4","a5","a6","a7","a8","a9","aa","ab","ac","ad","ae","af","b0","b1","b2","b3","b4","b5","b6","b7","b8","b9","ba","bb","bc","bd","be","bf","c0","c1","c2","c3","c4","c5","c6","c7","c8","c9","ca","cb","cc","cd","ce","cf","d0","d1","d2","d3","d4","d5","d6","d7","d8","d9","da","db","dc","dd","de","df","e0","e1","e2","e3","e4","e5","e6","e7","e8","e9","ea","eb","ec","ed","ee","ef","f0","f1","f2","f3","f4","f5","f6","f7","f8","f9","fa","fb","fc","fd","fe","ff"],uc=1234567,ki=Math.PI/180,Wi=180/Math.PI;function fs(){let n=Math.random()*4294967295|0,t=Math.random()*4294967295|0,e=Math.random()*4294967295|0,i=Math.random()*4294967295|0;return(Kt[n&255]+Kt[n>>8&255]+Kt[n>>16&255]+Kt[n>>24&255]+"-"+Kt[t&255]+Kt[t>>8&255]+"-"+Kt[t>>16&15|64]+Kt[t>>24&255]+"-"+Kt[e&63|128]+Kt[e>>8&255]+"-"+Kt[e>>16&255]+Kt[e>>24&255]+Kt[i&255]+Kt[i>>8&255]+Kt[i>>16&255]+Kt[i>>24&255]).toLowerCase()}function et(n,t,e){return Math.max(t,Math.min(e,n))}function Lo(n,t){return(n%t+t)%t}function Nm(n,t,e,i,r){return i+(n-t)*(r-i)/(e-t)}function Lm(n,t,e){return n!==t?(e-n)/(t-n):0}function Gi(n,t,e){return(1-e)*n+e*t}function Dm(n,t,e,i){return Gi(n,t,1-Math.exp(-e*i))}function Um(n,t=1){return t-Math.abs(Lo(n,t*2)-t)}function Fm(n,t,e){return n<=t?0:n>=e?1:(n=(n-t)/(e-t),n*n*(3-2*n))}function Om(n,t,e){return n<=t?0:n>=e?1:(n=(n-t)/(e-t),n*n*n*(n*(n*6-15)+10))}function Bm(n,t){return n+Math.floor(Math.random()*(t-n+1))}function zm(n,t){return n+Math.random()*(t-n)}function km(n){return n*(.5-Math.random())}function Gm(n){n!==void 0&&(uc=n);let t=uc+=1831565813;return t=Math.imul(t^t>>>15,t|1),t^=t+Math.imul(t^t>>>7,t|61),((t^t>>>14)>>>0)/4294967296}function Vm(n){return n*ki}function Hm(n){return n*Wi}function Wm(n){return n>0&&Number.isInteger(n)&&2**Math.round(Math.log2(n))===n}function Xm(n){return Math.pow(2,Math.ceil(Math.log(n)/Math.LN2))}function Bc(n){return Math.pow(2,Math.floor(Math.log(n)/Math.LN2))}function qm(n,t,e,i,r){let s=Math.cos,a=Math.sin,o=s(e/2),h=a(e/2),l=s((t+i)/2),c=a((t+i)/2),u=s((t-i)/2),d=a((t-i)/2),f=s((i-t)/2),p=a((i-t)/2);switch(r){case"XYX":n.set(o*c,h*u,h*d,o*l);break;case"YZY":n.set(h*d,o*c,h*u,o*l);break;case"ZXZ":n.set(h*u,h*d,o*c,o*l);break;case"XZX":n.set(o*c,h*p,h*f,o*l);break;case"YXY":n.set(h*f,o*c,h*p,o*l);break;case"ZYZ":n.set(h*p,h*f,o*c,o*l);break;default:Ht("MathUtils: .setQuaternionFromProperEuler() encountered an unknown order: "+r)}}function zc(n){switch(n.constructor){case Uint32Array:return 4294967295;case Uint16Array:return 65535;case Uint8Array:case Uint8ClampedArray:return 255;case Int32Array:return 2147483647;case Int16Array:return 32767;case Int8Array:return 127;default:return}}function Ym(n,t){if(t.constructor===Float32Array)return n;let e=zc(t);if(e===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.max(n/e,-1)}function Zm(n,t){if(t.constructor===Float32Array)return n;let e=zc(t);if(e===void 0)throw new Error("THREE.MathUtils: Invalid component type.");return Math.round(n*e)}var Te={DEG2RAD:ki,RAD2DEG:Wi,generateUUID:fs,clamp:et,euclideanModulo:Lo,mapLinear:Nm,inverseLerp:Lm,lerp:Gi,damp:Dm,pingpong:Um,smoothstep:Fm,smootherstep:Om,randInt:Bm,randFloat:zm,randFloatSpread:km,seededRandom:Gm,degToRad:Vm,radToDeg:Hm,isPowerOfTwo:Wm,ceilPowerOfTwo:Xm,floorPowerOfTwo:Bc,setQuaternionFromProperEuler:qm,normalize:Zm,denormalize:Ym},oe=class{static{this.prototype.isVector2=!0}constructor(t=0,e=0){this.x=t,this.y=e}get width(){return this.x}set width(t){this.x=t}get height(){return this.y}set height(t){this.y=t}set(t,e){return this.x=t,this.y=e,this}setScalar(t){return this.x=t,this.y=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;default:throw new Error("THREE.Vector2: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;default:throw new Error("THREE.Vector2: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y)}copy(t){return this.x=t.x,this.y=t.y,this}add(t){return this.x+=t.x,this.y+=t.y,this}addScalar(t){return this.x+=t,this.y+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this}subScalar(t){return this.x-=t,this.y-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this}multiply(t){return this.x*=t.x,this.y*=t.y,this}multiplyScalar(t){return this.x*=t,this.y*=t,this}divide(t){return this.x/=t.x,this.y/=t.y,this}divideScalar(t){return this.multiplyScalar(1/t)}applyMatrix3(t){let e=this.x,i=this.y,r=t.elements;return this.x=r[0]*e+r[3]*i+r[6],this.y=r[1]*e+r[4]*i+r[7],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this}clamp(t,e){return this.x=et(this.x,t.x,e.x),this.y=et(this.y,t.y,e.y),this}clampScalar(t,e){return this.x=et(this.x,t,e),this.y=et(this.y,t,e),this}clampLength(t,e){let i=this.length();return this.divideScalar(i||1).multiplyScalar(et(i,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this}negate(){return this.x=-this.x,this.y=-this.y,this}dot(t){return this.x*t.x+this.y*t.y}cross(t){return this.x*t.y-this.y*t.x}lengthSq(){return this.x*this.x+this.y*this.y}length(){return Math.sqrt(this.x*this.x+this.y*this.y)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)}normalize(){return this.divideScalar(this.length()||1)}angle(){return Math.atan2(-this.y,-this.x)+Math.PI}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let i=this.dot(t)/e;return Math.acos(et(i,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,i=this.y-t.y;return e*e+i*i}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this}lerpVectors(t,e,i){return this.x=t.x+(e.x-t.x)*i,this.y=t.y+(e.y-t.y)*i,this}equals(t){return t.x===this.x&&t.y===this.y}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this}rotateAround(t,e){let i=Math.cos(e),r=Math.sin(e),s=this.x-t.x,a=this.y-t.y;return this.x=s*i-a*r+t.x,this.y=s*r+a*i+t.y,this}random(){return this.x=Math.random(),this.y=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y}},De=class{constructor(t=0,e=0,i=0,r=1){this.isQuaternion=!0,this._x=t,this._y=e,this._z=i,this._w=r}static slerpFlat(t,e,i,r,s,a,o){let h=i[r+0],l=i[r+1],c=i[r+2],u=i[r+3],d=s[a+0],f=s[a+1],p=s[a+2],m=s[a+3];if(u!==m||h!==d||l!==f||c!==p){let g=h*d+l*f+c*p+u*m;g<0&&(d=-d,f=-f,p=-p,m=-m,g=-g);let _=1-o;if(g<.9995){let y=Math.acos(g),v=Math.sin(y);_=Math.sin(_*y)/v,o=Math.sin(o*y)/v,h=h*_+d*o,l=l*_+f*o,c=c*_+p*o,u=u*_+m*o}else{h=h*_+d*o,l=l*_+f*o,c=c*_+p*o,u=u*_+m*o;let y=1/Math.sqrt(h*h+l*l+c*c+u*u);h*=y,l*=y,c*=y,u*=y}}t[e]=h,t[e+1]=l,t[e+2]=c,t[e+3]=u}static multiplyQuaternionsFlat(t,e,i,r,s,a){let o=i[r],h=i[r+1],l=i[r+2],c=i[r+3],u=s[a],d=s[a+1],f=s[a+2],p=s[a+3];return t[e]=o*p+c*u+h*f-l*d,t[e+1]=h*p+c*d+l*u-o*f,t[e+2]=l*p+c*f+o*d-h*u,t[e+3]=c*p-o*u-h*d-l*f,t}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get w(){return this._w}set w(t){this._w=t,this._onChangeCallback()}set(t,e,i,r){return this._x=t,this._y=e,this._z=i,this._w=r,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._w)}copy(t){return this._x=t.x,this._y=t.y,this._z=t.z,this._w=t.w,this._onChangeCallback(),this}setFromEuler(t,e=!0){let i=t._x,r=t._y,s=t._z,a=t._order,o=Math.cos,h=Math.sin,l=o(i/2),c=o(r/2),u=o(s/2),d=h(i/2),f=h(r/2),p=h(s/2);switch(a){case"XYZ":this._x=d*c*u+l*f*p,this._y=l*f*u-d*c*p,this._z=l*c*p+d*f*u,this._w=l*c*u-d*f*p;break;case"YXZ":this._x=d*c*u+l*f*p,this._y=l*f*u-d*c*p,this._z=l*c*p-d*f*u,this._w=l*c*u+d*f*p;break;case"ZXY":this._x=d*c*u-l*f*p,this._y=l*f*u+d*c*p,this._z=l*c*p+d*f*u,this._w=l*c*u-d*f*p;break;case"ZYX":this._x=d*c*u-l*f*p,this._y=l*f*u+d*c*p,this._z=l*c*p-d*f*u,this._w=l*c*u+d*f*p;break;case"YZX":this._x=d*c*u+l*f*p,this._y=l*f*u+d*c*p,this._z=l*c*p-d*f*u,this._w=l*c*u-d*f*p;break;case"XZY":this._x=d*c*u-l*f*p,this._y=l*f*u-d*c*p,this._z=l*c*p+d*f*u,this._w=l*c*u+d*f*p;break;default:Ht("Quaternion: .setFromEuler() encountered an unknown order: "+a)}return e===!0&&this._onChangeCallback(),this}setFromAxisAngle(t,e){let i=e/2,r=Math.sin(i);return this._x=t.x*r,this._y=t.y*r,this._z=t.z*r,this._w=Math.cos(i),this._onChangeCallback(),this}setFromRotationMatrix(t){let e=t.elements,i=e[0],r=e[4],s=e[8],a=e[1],o=e[5],h=e[9],l=e[2],c=e[6],u=e[10],d=i+o+u;if(d>0){let f=.5/Math.sqrt(d+1);this._w=.25/f,this._x=(c-h)*f,this._y=(s-l)*f,this._z=(a-r)*f}else if(i>o&&i>u){let f=2*Math.sqrt(1+i-o-u);this._w=(c-h)/f,this._x=.25*f,this._y=(r+a)/f,this._z=(s+l)/f}else if(o>u){let f=2*Math.sqrt(1+o-i-u);this._w=(s-l)/f,this._x=(r+a)/f,this._y=.25*f,this._z=(h+c)/f}else{let f=2*Math.sqrt(1+u-i-o);this._w=(a-r)/f,this._x=(s+l)/f,this._y=(h+c)/f,this._z=.25*f}return this._onChangeCallback(),this}setFromUnitVectors(t,e){let i=t.dot(e)+1;return i<1e-8?(i=0,Math.abs(t.x)>Math.abs(t.z)?(this._x=-t.y,this._y=t.x,this._z=0,this._w=i):(this._x=0,this._y=-t.z,this._z=t.y,this._w=i)):(this._x=t.y*e.z-t.z*e.y,this._y=t.z*e.x-t.x*e.z,this._z=t.x*e.y-t.y*e.x,this._w=i),this.normalize()}angleTo(t){return 2*Math.acos(Math.abs(et(this.dot(t),-1,1)))}rotateTowards(t,e){let i=this.angleTo(t);if(i===0)return this;let r=Math.min(1,e/i);return this.slerp(t,r),this}identity(){return this.set(0,0,0,1)}invert(){return this.conjugate()}conjugate(){return this._x*=-1,this._y*=-1,this._z*=-1,this._onChangeCallback(),this}dot(t){return this._x*t._x+this._y*t._y+this._z*t._z+this._w*t._w}lengthSq(){return this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w}length(){return Math.sqrt(this._x*this._x+this._y*this._y+this._z*this._z+this._w*this._w)}normalize(){let t=this.length();return t===0?(this._x=0,this._y=0,this._z=0,this._w=1):(t=1/t,this._x=this._x*t,this._y=this._y*t,this._z=this._z*t,this._w=this._w*t),this._onChangeCallback(),this}multiply(t){return this.multiplyQuaternions(this,t)}premultiply(t){return this.multiplyQuaternions(t,this)}multiplyQuaternions(t,e){let i=t._x,r=t._y,s=t._z,a=t._w,o=e._x,h=e._y,l=e._z,c=e._w;return this._x=i*c+a*o+r*l-s*h,this._y=r*c+a*h+s*o-i*l,this._z=s*c+a*l+i*h-r*o,this._w=a*c-i*o-r*h-s*l,this._onChangeCallback(),this}slerp(t,e){let i=t._x,r=t._y,s=t._z,a=t._w,o=this.dot(t);o<0&&(i=-i,r=-r,s=-s,a=-a,o=-o);let h=1-e;if(o<.9995){let l=Math.acos(o),c=Math.sin(l);h=Math.sin(h*l)/c,e=Math.sin(e*l)/c,this._x=this._x*h+i*e,this._y=this._y*h+r*e,this._z=this._z*h+s*e,this._w=this._w*h+a*e,this._onChangeCallback()}else this._x=this._x*h+i*e,this._y=this._y*h+r*e,this._z=this._z*h+s*e,this._w=this._w*h+a*e,this.normalize();return this}slerpQuaternions(t,e,i){return this.copy(t).slerp(e,i)}random(){let t=2*Math.PI*Math.random(),e=2*Math.PI*Math.random(),i=Math.random(),r=Math.sqrt(1-i),s=Math.sqrt(i);return this.set(r*Math.sin(t),r*Math.cos(t),s*Math.sin(e),s*Math.cos(e))}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._w===this._w}fromArray(t,e=0){return this._x=t[e],this._y=t[e+1],this._z=t[e+2],this._w=t[e+3],this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._w,t}fromBufferAttribute(t,e){return this._x=t.getX(e),this._y=t.getY(e),this._z=t.getZ(e),this._w=t.getW(e),this._onChangeCallback(),this}toJSON(){return this.toArray()}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._w}},st=class{static{this.prototype.isVector3=!0}constructor(t=0,e=0,i=0){this.x=t,this.y=e,this.z=i}set(t,e,i){return i===void 0&&(i=this.z),this.x=t,this.y=e,this.z=i,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;default:throw new Error("THREE.Vector3: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;default:throw new Error("THREE.Vector3: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this}multiplyVectors(t,e){return this.x=t.x*e.x,this.y=t.y*e.y,this.z=t.z*e.z,this}applyEuler(t){return this.applyQuaternion(fc.setFromEuler(t))}applyAxisAngle(t,e){return this.applyQuaternion(fc.setFromAxisAngle(t,e))}applyMatrix3(t){let e=this.x,i=this.y,r=this.z,s=t.elements;return this.x=s[0]*e+s[3]*i+s[6]*r,this.y=s[1]*e+s[4]*i+s[7]*r,this.z=s[2]*e+s[5]*i+s[8]*r,this}applyNormalMatrix(t){return this.applyMatrix3(t).normalize()}applyMatrix4(t){let e=this.x,i=this.y,r=this.z,s=t.elements,a=1/(s[3]*e+s[7]*i+s[11]*r+s[15]);return this.x=(s[0]*e+s[4]*i+s[8]*r+s[12])*a,this.y=(s[1]*e+s[5]*i+s[9]*r+s[13])*a,this.z=(s[2]*e+s[6]*i+s[10]*r+s[14])*a,this}applyQuaternion(t){let e=this.x,i=this.y,r=this.z,s=t.x,a=t.y,o=t.z,h=t.w,l=2*(a*r-o*i),c=2*(o*e-s*r),u=2*(s*i-a*e);return this.x=e+h*l+a*u-o*c,this.y=i+h*c+o*l-s*u,this.z=r+h*u+s*c-a*l,this}project(t){return this.applyMatrix4(t.matrixWorldInverse).applyMatrix4(t.projectionMatrix)}unproject(t){return this.applyMatrix4(t.projectionMatrixInverse).applyMatrix4(t.matrixWorld)}transformDirection(t){let e=this.x,i=this.y,r=this.z,s=t.elements;return this.x=s[0]*e+s[4]*i+s[8]*r,this.y=s[1]*e+s[5]*i+s[9]*r,this.z=s[2]*e+s[6]*i+s[10]*r,this.normalize()}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this}divideScalar(t){return this.multiplyScalar(1/t)}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this}clamp(t,e){return this.x=et(this.x,t.x,e.x),this.y=et(this.y,t.y,e.y),this.z=et(this.z,t.z,e.z),this}clampScalar(t,e){return this.x=et(this.x,t,e),this.y=et(this.y,t,e),this.z=et(this.z,t,e),this}clampLength(t,e){let i=this.length();return this.divideScalar(i||1).multiplyScalar(et(i,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this}lerpVectors(t,e,i){return this.x=t.x+(e.x-t.x)*i,this.y=t.y+(e.y-t.y)*i,this.z=t.z+(e.z-t.z)*i,this}cross(t){return this.crossVectors(this,t)}crossVectors(t,e){let i=t.x,r=t.y,s=t.z,a=e.x,o=e.y,h=e.z;return this.x=r*h-s*o,this.y=s*a-i*h,this.z=i*o-r*a,this}projectOnVector(t){let e=t.lengthSq();if(e===0)return this.set(0,0,0);let i=t.dot(this)/e;return this.copy(t).multiplyScalar(i)}projectOnPlane(t){return $a.copy(this).projectOnVector(t),this.sub($a)}reflect(t){return this.sub($a.copy(t).multiplyScalar(2*this.dot(t)))}angleTo(t){let e=Math.sqrt(this.lengthSq()*t.lengthSq());if(e===0)return Math.PI/2;let i=this.dot(t)/e;return Math.acos(et(i,-1,1))}distanceTo(t){return Math.sqrt(this.distanceToSquared(t))}distanceToSquared(t){let e=this.x-t.x,i=this.y-t.y,r=this.z-t.z;return e*e+i*i+r*r}manhattanDistanceTo(t){return Math.abs(this.x-t.x)+Math.abs(this.y-t.y)+Math.abs(this.z-t.z)}setFromSpherical(t){return this.setFromSphericalCoords(t.radius,t.phi,t.theta)}setFromSphericalCoords(t,e,i){let r=Math.sin(e)*t;return this.x=r*Math.sin(i),this.y=Math.cos(e)*t,this.z=r*Math.cos(i),this}setFromCylindrical(t){return this.setFromCylindricalCoords(t.radius,t.theta,t.y)}setFromCylindricalCoords(t,e,i){return this.x=t*Math.sin(e),this.y=i,this.z=t*Math.cos(e),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this}setFromMatrixScale(t){let e=this.setFromMatrixColumn(t,0).length(),i=this.setFromMatrixColumn(t,1).length(),r=this.setFromMatrixColumn(t,2).length();return this.x=e,this.y=i,this.z=r,this}setFromMatrixColumn(t,e){return this.fromArray(t.elements,e*4)}setFromMatrix3Column(t,e){return this.fromArray(t.elements,e*3)}setFromEuler(t){return this.x=t._x,this.y=t._y,this.z=t._z,this}setFromColor(t){return this.x=t.r,this.y=t.g,this.z=t.b,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this}randomDirection(){let t=Math.random()*Math.PI*2,e=Math.random()*2-1,i=Math.sqrt(1-e*e);return this.x=i*Math.cos(t),this.y=e,this.z=i*Math.sin(t),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z}},$a=new st,fc=new De,K=class{static{this.prototype.isMatrix3=!0}constructor(t,e,i,r,s,a,o,h,l){this.elements=[1,0,0,0,1,0,0,0,1],t!==void 0&&this.set(t,e,i,r,s,a,o,h,l)}set(t,e,i,r,s,a,o,h,l){let c=this.elements;return c[0]=t,c[1]=r,c[2]=o,c[3]=e,c[4]=s,c[5]=h,c[6]=i,c[7]=a,c[8]=l,this}identity(){return this.set(1,0,0,0,1,0,0,0,1),this}copy(t){let e=this.elements,i=t.elements;return e[0]=i[0],e[1]=i[1],e[2]=i[2],e[3]=i[3],e[4]=i[4],e[5]=i[5],e[6]=i[6],e[7]=i[7],e[8]=i[8],this}extractBasis(t,e,i){return t.setFromMatrix3Column(this,0),e.setFromMatrix3Column(this,1),i.setFromMatrix3Column(this,2),this}setFromMatrix4(t){let e=t.elements;return this.set(e[0],e[4],e[8],e[1],e[5],e[9],e[2],e[6],e[10]),this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let i=t.elements,r=e.elements,s=this.elements,a=i[0],o=i[3],h=i[6],l=i[1],c=i[4],u=i[7],d=i[2],f=i[5],p=i[8],m=r[0],g=r[3],_=r[6],y=r[1],v=r[4],x=r[7],w=r[2],b=r[5],A=r[8];return s[0]=a*m+o*y+h*w,s[3]=a*g+o*v+h*b,s[6]=a*_+o*x+h*A,s[1]=l*m+c*y+u*w,s[4]=l*g+c*v+u*b,s[7]=l*_+c*x+u*A,s[2]=d*m+f*y+p*w,s[5]=d*g+f*v+p*b,s[8]=d*_+f*x+p*A,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[3]*=t,e[6]*=t,e[1]*=t,e[4]*=t,e[7]*=t,e[2]*=t,e[5]*=t,e[8]*=t,this}determinant(){let t=this.elements,e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8];return e*a*c-e*o*l-i*s*c+i*o*h+r*s*l-r*a*h}invert(){let t=this.elements,e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8],u=c*a-o*l,d=o*h-c*s,f=l*s-a*h,p=e*u+i*d+r*f;if(p===0)return this.set(0,0,0,0,0,0,0,0,0);let m=1/p;return t[0]=u*m,t[1]=(r*l-c*i)*m,t[2]=(o*i-r*a)*m,t[3]=d*m,t[4]=(c*e-r*h)*m,t[5]=(r*s-o*e)*m,t[6]=f*m,t[7]=(i*h-l*e)*m,t[8]=(a*e-i*s)*m,this}transpose(){let t,e=this.elements;return t=e[1],e[1]=e[3],e[3]=t,t=e[2],e[2]=e[6],e[6]=t,t=e[5],e[5]=e[7],e[7]=t,this}getNormalMatrix(t){return this.setFromMatrix4(t).invert().transpose()}transposeIntoArray(t){let e=this.elements;return t[0]=e[0],t[1]=e[3],t[2]=e[6],t[3]=e[1],t[4]=e[4],t[5]=e[7],t[6]=e[2],t[7]=e[5],t[8]=e[8],this}setUvTransform(t,e,i,r,s,a,o){let h=Math.cos(s),l=Math.sin(s);return this.set(i*h,i*l,-i*(h*a+l*o)+a+t,-r*l,r*h,-r*(-l*a+h*o)+o+e,0,0,1),this}scale(t,e){return $r("Matrix3: .scale() is deprecated. Use .makeScale() instead."),this.premultiply(Ka.makeScale(t,e)),this}rotate(t){return $r("Matrix3: .rotate() is deprecated. Use .makeRotation() instead."),this.premultiply(Ka.makeRotation(-t)),this}translate(t,e){return $r("Matrix3: .translate() is deprecated. Use .makeTranslation() instead."),this.premultiply(Ka.makeTranslation(t,e)),this}makeTranslation(t,e){return t.isVector2?this.set(1,0,t.x,0,1,t.y,0,0,1):this.set(1,0,t,0,1,e,0,0,1),this}makeRotation(t){let e=Math.cos(t),i=Math.sin(t);return this.set(e,-i,0,i,e,0,0,0,1),this}makeScale(t,e){return this.set(t,0,0,0,e,0,0,0,1),this}equals(t){let e=this.elements,i=t.elements;for(let r=0;r<9;r++)if(e[r]!==i[r])return!1;return!0}fromArray(t,e=0){for(let i=0;i<9;i++)this.elements[i]=t[i+e];return this}toArray(t=[],e=0){let i=this.elements;return t[e]=i[0],t[e+1]=i[1],t[e+2]=i[2],t[e+3]=i[3],t[e+4]=i[4],t[e+5]=i[5],t[e+6]=i[6],t[e+7]=i[7],t[e+8]=i[8],t}clone(){return new this.constructor().fromArray(this.elements)}},Ka=new K,dc=new K().set(.4123908,.3575843,.1804808,.212639,.7151687,.0721923,.0193308,.1191948,.9505322),pc=new K().set(3.2409699,-1.5373832,-.4986108,-.9692436,1.8759675,.0415551,.0556301,-.203977,1.0569715);function Jm(){let n={enabled:!0,workingColorSpace:_o,spaces:{},convert:function(r,s,a){return this.enabled===!1||s===a||!s||!a||(this.spaces[s].transfer===Jr&&(r.r=Je(r.r),r.g=Je(r.g),r.b=Je(r.b)),this.spaces[s].primaries!==this.spaces[a].primaries&&(r.applyMatrix3(this.spaces[s].toXYZ),r.applyMatrix3(this.spaces[a].fromXYZ)),this.spaces[a].transfer===Jr&&(r.r=ci(r.r),r.g=ci(r.g),r.b=ci(r.b))),r},workingToColorSpace:function(r,s){return this.convert(r,this.workingColorSpace,s)},colorSpaceToWorking:function(r,s){return this.convert(r,s,this.workingColorSpace)},getPrimaries:function(r){return this.spaces[r].primaries},getTransfer:function(r){return r===No?xo:this.spaces[r].transfer},getToneMappingMode:function(r){return this.spaces[r].outputColorSpaceConfig.toneMappingMode||"standard"},getLuminanceCoefficients:function(r,s=this.workingColorSpace){return r.fromArray(this.spaces[s].luminanceCoefficients)},define:function(r){Object.assign(this.spaces,r)},_getMatrix:function(r,s,a){return r.copy(this.spaces[a].fromXYZ).multiply(this.spaces[s].toXYZ)},_getDrawingBufferColorSpace:function(r){return this.spaces[r].outputColorSpaceConfig.drawingBufferColorSpace},_getUnpackColorSpace:function(r=this.workingColorSpace){return this.spaces[r].workingColorSpaceConfig.unpackColorSpace}},t=[.64,.33,.3,.6,.15,.06],e=[.2126,.7152,.0722],i=[.3127,.329];return n.define({[_o]:{primaries:t,whitePoint:i,transfer:xo,toXYZ:dc,fromXYZ:pc,luminanceCoefficients:e,workingColorSpaceConfig:{unpackColorSpace:ge},outputColorSpaceConfig:{drawingBufferColorSpace:ge}},[ge]:{primaries:t,whitePoint:i,transfer:Jr,toXYZ:dc,fromXYZ:pc,luminanceCoefficients:e,outputColorSpaceConfig:{drawingBufferColorSpace:ge}}}),n}var me=Jm();function Je(n){return n<.04045?n*.0773993808:Math.pow(n*.9478672986+.0521327014,2.4)}function ci(n){return n<.0031308?n*12.92:1.055*Math.pow(n,.41666)-.055}var ii,jr=class{static getDataURL(t,e="image/png"){if(/^data:/i.test(t.src)||typeof HTMLCanvasElement>"u")return t.src;let i;if(t instanceof HTMLCanvasElement)i=t;else{ii===void 0&&(ii=yo("canvas")),ii.width=t.width,ii.height=t.height;let r=ii.getContext("2d");t instanceof ImageData?r.putImageData(t,0,0):r.drawImage(t,0,0,t.width,t.height),i=ii}return i.toDataURL(e)}static sRGBToLinear(t){if(typeof HTMLImageElement<"u"&&t instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&t instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&t instanceof ImageBitmap){let e=yo("canvas");e.width=t.width,e.height=t.height;let i=e.getContext("2d");i.drawImage(t,0,0,t.width,t.height);let r=i.getImageData(0,0,t.width,t.height),s=r.data;for(let a=0;a<s.length;a++)s[a]=Je(s[a]/255)*255;return i.putImageData(r,0,0),e}else if(t.data){let e=t.data.slice(0);for(let i=0;i<e.length;i++)e instanceof Uint8Array||e instanceof Uint8ClampedArray?e[i]=Math.floor(Je(e[i]/255)*255):e[i]=Je(e[i]);return{data:e,width:t.width,height:t.height}}else return Ht("ImageUtils.sRGBToLinear(): Unsupported image type. No color space conversion applied."),t}},$m=0,ts=class{constructor(t=null){this.isTextureSource=!0,Object.defineProperty(this,"id",{value:$m++}),this.uuid=fs(),this.data=t,this.dataReady=!0,this.version=0}getSize(t){let e=this.data;return typeof HTMLVideoElement<"u"&&e instanceof HTMLVideoElement?t.set(e.videoWidth,e.videoHeight,0):typeof VideoFrame<"u"&&e instanceof VideoFrame?t.set(e.displayWidth,e.displayHeight,0):e!==null?t.set(e.width||0,e.height||0,e.depth||0):t.set(0,0,0),t}set needsUpdate(t){t===!0&&this.version++}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.images[this.uuid]!==void 0)return t.images[this.uuid];let i={uuid:this.uuid,url:""},r=this.data;if(r!==null){let s;if(Array.isArray(r)){s=[];for(let a=0,o=r.length;a<o;a++)r[a].isDataTexture?s.push(Qa(r[a].image)):s.push(Qa(r[a]))}else s=Qa(r);i.url=s}return e||(t.images[this.uuid]=i),i}};function Qa(n){return typeof HTMLImageElement<"u"&&n instanceof HTMLImageElement||typeof HTMLCanvasElement<"u"&&n instanceof HTMLCanvasElement||typeof ImageBitmap<"u"&&n instanceof ImageBitmap?jr.getDataURL(n):n.data?{data:Array.from(n.data),width:n.width,height:n.height,type:n.data.constructor.name}:(Ht("Texture: Unable to serialize Texture."),{})}var Km=0,ja=new st,hi=class n extends Hi{constructor(t=n.DEFAULT_IMAGE,e=n.DEFAULT_MAPPING,i=zi,r=zi,s=Lc,a=Dc,o=Fc,h=Uc,l=n.DEFAULT_ANISOTROPY,c=No){super(),this.isTexture=!0,Object.defineProperty(this,"id",{value:Km++}),this.uuid=fs(),this.name="",this.source=new ts(t),this.mipmaps=[],this.mapping=e,this.channel=0,this.wrapS=i,this.wrapT=r,this.magFilter=s,this.minFilter=a,this.anisotropy=l,this.format=o,this.internalFormat=null,this.type=h,this.offset=new oe(0,0),this.repeat=new oe(1,1),this.center=new oe(0,0),this.rotation=0,this.matrixAutoUpdate=!0,this.matrix=new K,this.generateMipmaps=!0,this.mipmapsAutoUpdate=!0,this.premultiplyAlpha=!1,this.flipY=!0,this.unpackAlignment=4,this.colorSpace=c,this.userData={},this.updateRanges=[],this.version=0,this.onUpdate=null,this.renderTarget=null,this.isRenderTargetTexture=!1,this.isArrayTexture=!!(t&&t.depth&&t.depth>1),this.pmremVersion=0,this.isPMREMTexture=!1,this.normalized=!1}get width(){return this.source.getSize(ja).x}get height(){return this.source.getSize(ja).y}get depth(){return this.source.getSize(ja).z}get image(){return this.source.data}set image(t){this.source.data=t}updateMatrix(){this.matrix.setUvTransform(this.offset.x,this.offset.y,this.repeat.x,this.repeat.y,this.rotation,this.center.x,this.center.y)}addUpdateRange(t,e){this.updateRanges.push({start:t,count:e})}clearUpdateRanges(){this.updateRanges.length=0}clone(){return new this.constructor().copy(this)}copy(t){return this.name=t.name,this.source=t.source,this.mipmaps=t.mipmaps.slice(0),this.mapping=t.mapping,this.channel=t.channel,this.wrapS=t.wrapS,this.wrapT=t.wrapT,this.magFilter=t.magFilter,this.minFilter=t.minFilter,this.anisotropy=t.anisotropy,this.format=t.format,this.internalFormat=t.internalFormat,this.type=t.type,this.normalized=t.normalized,this.offset.copy(t.offset),this.repeat.copy(t.repeat),this.center.copy(t.center),this.rotation=t.rotation,this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrix.copy(t.matrix),this.generateMipmaps=t.generateMipmaps,this.mipmapsAutoUpdate=t.mipmapsAutoUpdate,this.premultiplyAlpha=t.premultiplyAlpha,this.flipY=t.flipY,this.unpackAlignment=t.unpackAlignment,this.colorSpace=t.colorSpace,this.renderTarget=t.renderTarget,this.isRenderTargetTexture=t.isRenderTargetTexture,this.isPMREMTexture=t.isPMREMTexture,this.isArrayTexture=t.isArrayTexture,this.userData=JSON.parse(JSON.stringify(t.userData)),this.needsUpdate=!0,this}setValues(t){for(let e in t){let i=t[e];if(i===void 0){Ht(`Texture.setValues(): parameter '${e}' has value of undefined.`);continue}let r=this[e];if(r===void 0){Ht(`Texture.setValues(): property '${e}' does not exist.`);continue}r&&i&&r.isVector2&&i.isVector2||r&&i&&r.isVector3&&i.isVector3||r&&i&&r.isMatrix3&&i.isMatrix3?r.copy(i):this[e]=i}}toJSON(t){let e=t===void 0||typeof t=="string";if(!e&&t.textures[this.uuid]!==void 0)return t.textures[this.uuid];let i={metadata:{version:4.7,type:"Texture",generator:"Texture.toJSON"},uuid:this.uuid,name:this.name,image:this.source.toJSON(t).uuid,mapping:this.mapping,channel:this.channel,repeat:[this.repeat.x,this.repeat.y],offset:[this.offset.x,this.offset.y],center:[this.center.x,this.center.y],rotation:this.rotation,wrap:[this.wrapS,this.wrapT],format:this.format,internalFormat:this.internalFormat,type:this.type,normalized:this.normalized,colorSpace:this.colorSpace,minFilter:this.minFilter,magFilter:this.magFilter,anisotropy:this.anisotropy,flipY:this.flipY,generateMipmaps:this.generateMipmaps,mipmapsAutoUpdate:this.mipmapsAutoUpdate,premultiplyAlpha:this.premultiplyAlpha,unpackAlignment:this.unpackAlignment};return Object.keys(this.userData).length>0&&(i.userData=this.userData),e||(t.textures[this.uuid]=i),i}dispose(){this.dispatchEvent({type:"dispose"})}transformUv(t){if(this.mapping!==Po)return t;if(t.applyMatrix3(this.matrix),t.x<0||t.x>1)switch(this.wrapS){case ho:t.x=t.x-Math.floor(t.x);break;case zi:t.x=t.x<0?0:1;break;case uo:Math.abs(Math.floor(t.x)%2)===1?t.x=Math.ceil(t.x)-t.x:t.x=t.x-Math.floor(t.x);break}if(t.y<0||t.y>1)switch(this.wrapT){case ho:t.y=t.y-Math.floor(t.y);break;case zi:t.y=t.y<0?0:1;break;case uo:Math.abs(Math.floor(t.y)%2)===1?t.y=Math.ceil(t.y)-t.y:t.y=t.y-Math.floor(t.y);break}return this.flipY&&(t.y=1-t.y),t}set needsUpdate(t){t===!0&&(this.version++,this.source.needsUpdate=!0)}set needsPMREMUpdate(t){t===!0&&this.pmremVersion++}};hi.DEFAULT_IMAGE=null;hi.DEFAULT_MAPPING=Po;hi.DEFAULT_ANISOTROPY=1;var So=class{static{this.prototype.isVector4=!0}constructor(t=0,e=0,i=0,r=1){this.x=t,this.y=e,this.z=i,this.w=r}get width(){return this.z}set width(t){this.z=t}get height(){return this.w}set height(t){this.w=t}set(t,e,i,r){return this.x=t,this.y=e,this.z=i,this.w=r,this}setScalar(t){return this.x=t,this.y=t,this.z=t,this.w=t,this}setX(t){return this.x=t,this}setY(t){return this.y=t,this}setZ(t){return this.z=t,this}setW(t){return this.w=t,this}setComponent(t,e){switch(t){case 0:this.x=e;break;case 1:this.y=e;break;case 2:this.z=e;break;case 3:this.w=e;break;default:throw new Error("THREE.Vector4: index is out of range: "+t)}return this}getComponent(t){switch(t){case 0:return this.x;case 1:return this.y;case 2:return this.z;case 3:return this.w;default:throw new Error("THREE.Vector4: index is out of range: "+t)}}clone(){return new this.constructor(this.x,this.y,this.z,this.w)}copy(t){return this.x=t.x,this.y=t.y,this.z=t.z,this.w=t.w!==void 0?t.w:1,this}add(t){return this.x+=t.x,this.y+=t.y,this.z+=t.z,this.w+=t.w,this}addScalar(t){return this.x+=t,this.y+=t,this.z+=t,this.w+=t,this}addVectors(t,e){return this.x=t.x+e.x,this.y=t.y+e.y,this.z=t.z+e.z,this.w=t.w+e.w,this}addScaledVector(t,e){return this.x+=t.x*e,this.y+=t.y*e,this.z+=t.z*e,this.w+=t.w*e,this}sub(t){return this.x-=t.x,this.y-=t.y,this.z-=t.z,this.w-=t.w,this}subScalar(t){return this.x-=t,this.y-=t,this.z-=t,this.w-=t,this}subVectors(t,e){return this.x=t.x-e.x,this.y=t.y-e.y,this.z=t.z-e.z,this.w=t.w-e.w,this}multiply(t){return this.x*=t.x,this.y*=t.y,this.z*=t.z,this.w*=t.w,this}multiplyScalar(t){return this.x*=t,this.y*=t,this.z*=t,this.w*=t,this}applyMatrix4(t){let e=this.x,i=this.y,r=this.z,s=this.w,a=t.elements;return this.x=a[0]*e+a[4]*i+a[8]*r+a[12]*s,this.y=a[1]*e+a[5]*i+a[9]*r+a[13]*s,this.z=a[2]*e+a[6]*i+a[10]*r+a[14]*s,this.w=a[3]*e+a[7]*i+a[11]*r+a[15]*s,this}divide(t){return this.x/=t.x,this.y/=t.y,this.z/=t.z,this.w/=t.w,this}divideScalar(t){return this.multiplyScalar(1/t)}setAxisAngleFromQuaternion(t){this.w=2*Math.acos(t.w);let e=Math.sqrt(1-t.w*t.w);return e<1e-4?(this.x=1,this.y=0,this.z=0):(this.x=t.x/e,this.y=t.y/e,this.z=t.z/e),this}setAxisAngleFromRotationMatrix(t){let e,i,r,s,h=t.elements,l=h[0],c=h[4],u=h[8],d=h[1],f=h[5],p=h[9],m=h[2],g=h[6],_=h[10];if(Math.abs(c-d)<.01&&Math.abs(u-m)<.01&&Math.abs(p-g)<.01){if(Math.abs(c+d)<.1&&Math.abs(u+m)<.1&&Math.abs(p+g)<.1&&Math.abs(l+f+_-3)<.1)return this.set(1,0,0,0),this;e=Math.PI;let v=(l+1)/2,x=(f+1)/2,w=(_+1)/2,b=(c+d)/4,A=(u+m)/4,I=(p+g)/4;return v>x&&v>w?v<.01?(i=0,r=.707106781,s=.707106781):(i=Math.sqrt(v),r=b/i,s=A/i):x>w?x<.01?(i=.707106781,r=0,s=.707106781):(r=Math.sqrt(x),i=b/r,s=I/r):w<.01?(i=.707106781,r=.707106781,s=0):(s=Math.sqrt(w),i=A/s,r=I/s),this.set(i,r,s,e),this}let y=Math.sqrt((g-p)*(g-p)+(u-m)*(u-m)+(d-c)*(d-c));return Math.abs(y)<.001&&(y=1),this.x=(g-p)/y,this.y=(u-m)/y,this.z=(d-c)/y,this.w=Math.acos((l+f+_-1)/2),this}setFromMatrixPosition(t){let e=t.elements;return this.x=e[12],this.y=e[13],this.z=e[14],this.w=e[15],this}min(t){return this.x=Math.min(this.x,t.x),this.y=Math.min(this.y,t.y),this.z=Math.min(this.z,t.z),this.w=Math.min(this.w,t.w),this}max(t){return this.x=Math.max(this.x,t.x),this.y=Math.max(this.y,t.y),this.z=Math.max(this.z,t.z),this.w=Math.max(this.w,t.w),this}clamp(t,e){return this.x=et(this.x,t.x,e.x),this.y=et(this.y,t.y,e.y),this.z=et(this.z,t.z,e.z),this.w=et(this.w,t.w,e.w),this}clampScalar(t,e){return this.x=et(this.x,t,e),this.y=et(this.y,t,e),this.z=et(this.z,t,e),this.w=et(this.w,t,e),this}clampLength(t,e){let i=this.length();return this.divideScalar(i||1).multiplyScalar(et(i,t,e))}floor(){return this.x=Math.floor(this.x),this.y=Math.floor(this.y),this.z=Math.floor(this.z),this.w=Math.floor(this.w),this}ceil(){return this.x=Math.ceil(this.x),this.y=Math.ceil(this.y),this.z=Math.ceil(this.z),this.w=Math.ceil(this.w),this}round(){return this.x=Math.round(this.x),this.y=Math.round(this.y),this.z=Math.round(this.z),this.w=Math.round(this.w),this}roundToZero(){return this.x=Math.trunc(this.x),this.y=Math.trunc(this.y),this.z=Math.trunc(this.z),this.w=Math.trunc(this.w),this}negate(){return this.x=-this.x,this.y=-this.y,this.z=-this.z,this.w=-this.w,this}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z+this.w*t.w}lengthSq(){return this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z+this.w*this.w)}manhattanLength(){return Math.abs(this.x)+Math.abs(this.y)+Math.abs(this.z)+Math.abs(this.w)}normalize(){return this.divideScalar(this.length()||1)}setLength(t){return this.normalize().multiplyScalar(t)}lerp(t,e){return this.x+=(t.x-this.x)*e,this.y+=(t.y-this.y)*e,this.z+=(t.z-this.z)*e,this.w+=(t.w-this.w)*e,this}lerpVectors(t,e,i){return this.x=t.x+(e.x-t.x)*i,this.y=t.y+(e.y-t.y)*i,this.z=t.z+(e.z-t.z)*i,this.w=t.w+(e.w-t.w)*i,this}equals(t){return t.x===this.x&&t.y===this.y&&t.z===this.z&&t.w===this.w}fromArray(t,e=0){return this.x=t[e],this.y=t[e+1],this.z=t[e+2],this.w=t[e+3],this}toArray(t=[],e=0){return t[e]=this.x,t[e+1]=this.y,t[e+2]=this.z,t[e+3]=this.w,t}fromBufferAttribute(t,e){return this.x=t.getX(e),this.y=t.getY(e),this.z=t.getZ(e),this.w=t.getW(e),this}random(){return this.x=Math.random(),this.y=Math.random(),this.z=Math.random(),this.w=Math.random(),this}*[Symbol.iterator](){yield this.x,yield this.y,yield this.z,yield this.w}};var _e=class n{static{this.prototype.isMatrix4=!0}constructor(t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g){this.elements=[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],t!==void 0&&this.set(t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g)}set(t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g){let _=this.elements;return _[0]=t,_[4]=e,_[8]=i,_[12]=r,_[1]=s,_[5]=a,_[9]=o,_[13]=h,_[2]=l,_[6]=c,_[10]=u,_[14]=d,_[3]=f,_[7]=p,_[11]=m,_[15]=g,this}identity(){return this.set(1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1),this}clone(){return new n().fromArray(this.elements)}copy(t){let e=this.elements,i=t.elements;return e[0]=i[0],e[1]=i[1],e[2]=i[2],e[3]=i[3],e[4]=i[4],e[5]=i[5],e[6]=i[6],e[7]=i[7],e[8]=i[8],e[9]=i[9],e[10]=i[10],e[11]=i[11],e[12]=i[12],e[13]=i[13],e[14]=i[14],e[15]=i[15],this}copyPosition(t){let e=this.elements,i=t.elements;return e[12]=i[12],e[13]=i[13],e[14]=i[14],this}setFromMatrix3(t){let e=t.elements;return this.set(e[0],e[3],e[6],0,e[1],e[4],e[7],0,e[2],e[5],e[8],0,0,0,0,1),this}extractBasis(t,e,i){return this.determinantAffine()===0?(t.set(1,0,0),e.set(0,1,0),i.set(0,0,1),this):(t.setFromMatrixColumn(this,0),e.setFromMatrixColumn(this,1),i.setFromMatrixColumn(this,2),this)}makeBasis(t,e,i){return this.set(t.x,e.x,i.x,0,t.y,e.y,i.y,0,t.z,e.z,i.z,0,0,0,0,1),this}extractRotation(t){if(t.determinantAffine()===0)return this.identity();let e=this.elements,i=t.elements,r=1/ri.setFromMatrixColumn(t,0).length(),s=1/ri.setFromMatrixColumn(t,1).length(),a=1/ri.setFromMatrixColumn(t,2).length();return e[0]=i[0]*r,e[1]=i[1]*r,e[2]=i[2]*r,e[3]=0,e[4]=i[4]*s,e[5]=i[5]*s,e[6]=i[6]*s,e[7]=0,e[8]=i[8]*a,e[9]=i[9]*a,e[10]=i[10]*a,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromEuler(t){let e=this.elements,i=t.x,r=t.y,s=t.z,a=Math.cos(i),o=Math.sin(i),h=Math.cos(r),l=Math.sin(r),c=Math.cos(s),u=Math.sin(s);if(t.order==="XYZ"){let d=a*c,f=a*u,p=o*c,m=o*u;e[0]=h*c,e[4]=-h*u,e[8]=l,e[1]=f+p*l,e[5]=d-m*l,e[9]=-o*h,e[2]=m-d*l,e[6]=p+f*l,e[10]=a*h}else if(t.order==="YXZ"){let d=h*c,f=h*u,p=l*c,m=l*u;e[0]=d+m*o,e[4]=p*o-f,e[8]=a*l,e[1]=a*u,e[5]=a*c,e[9]=-o,e[2]=f*o-p,e[6]=m+d*o,e[10]=a*h}else if(t.order==="ZXY"){let d=h*c,f=h*u,p=l*c,m=l*u;e[0]=d-m*o,e[4]=-a*u,e[8]=p+f*o,e[1]=f+p*o,e[5]=a*c,e[9]=m-d*o,e[2]=-a*l,e[6]=o,e[10]=a*h}else if(t.order==="ZYX"){let d=a*c,f=a*u,p=o*c,m=o*u;e[0]=h*c,e[4]=p*l-f,e[8]=d*l+m,e[1]=h*u,e[5]=m*l+d,e[9]=f*l-p,e[2]=-l,e[6]=o*h,e[10]=a*h}else if(t.order==="YZX"){let d=a*h,f=a*l,p=o*h,m=o*l;e[0]=h*c,e[4]=m-d*u,e[8]=p*u+f,e[1]=u,e[5]=a*c,e[9]=-o*c,e[2]=-l*c,e[6]=f*u+p,e[10]=d-m*u}else if(t.order==="XZY"){let d=a*h,f=a*l,p=o*h,m=o*l;e[0]=h*c,e[4]=-u,e[8]=l*c,e[1]=d*u+m,e[5]=a*c,e[9]=f*u-p,e[2]=p*u-f,e[6]=o*c,e[10]=m*u+d}return e[3]=0,e[7]=0,e[11]=0,e[12]=0,e[13]=0,e[14]=0,e[15]=1,this}makeRotationFromQuaternion(t){return this.compose(Qm,t,jm)}lookAt(t,e,i){let r=this.elements;return ae.subVectors(t,e),ae.lengthSq()===0&&(ae.z=1),ae.normalize(),an.crossVectors(i,ae),an.lengthSq()===0&&(Math.abs(i.z)===1?ae.x+=1e-4:ae.z+=1e-4,ae.normalize(),an.crossVectors(i,ae)),an.normalize(),Vr.crossVectors(ae,an),r[0]=an.x,r[4]=Vr.x,r[8]=ae.x,r[1]=an.y,r[5]=Vr.y,r[9]=ae.y,r[2]=an.z,r[6]=Vr.z,r[10]=ae.z,this}multiply(t){return this.multiplyMatrices(this,t)}premultiply(t){return this.multiplyMatrices(t,this)}multiplyMatrices(t,e){let i=t.elements,r=e.elements,s=this.elements,a=i[0],o=i[4],h=i[8],l=i[12],c=i[1],u=i[5],d=i[9],f=i[13],p=i[2],m=i[6],g=i[10],_=i[14],y=i[3],v=i[7],x=i[11],w=i[15],b=r[0],A=r[4],I=r[8],C=r[12],P=r[1],L=r[5],G=r[9],q=r[13],V=r[2],B=r[6],pt=r[10],at=r[14],N=r[3],O=r[7],H=r[11],gt=r[15];return s[0]=a*b+o*P+h*V+l*N,s[4]=a*A+o*L+h*B+l*O,s[8]=a*I+o*G+h*pt+l*H,s[12]=a*C+o*q+h*at+l*gt,s[1]=c*b+u*P+d*V+f*N,s[5]=c*A+u*L+d*B+f*O,s[9]=c*I+u*G+d*pt+f*H,s[13]=c*C+u*q+d*at+f*gt,s[2]=p*b+m*P+g*V+_*N,s[6]=p*A+m*L+g*B+_*O,s[10]=p*I+m*G+g*pt+_*H,s[14]=p*C+m*q+g*at+_*gt,s[3]=y*b+v*P+x*V+w*N,s[7]=y*A+v*L+x*B+w*O,s[11]=y*I+v*G+x*pt+w*H,s[15]=y*C+v*q+x*at+w*gt,this}multiplyScalar(t){let e=this.elements;return e[0]*=t,e[4]*=t,e[8]*=t,e[12]*=t,e[1]*=t,e[5]*=t,e[9]*=t,e[13]*=t,e[2]*=t,e[6]*=t,e[10]*=t,e[14]*=t,e[3]*=t,e[7]*=t,e[11]*=t,e[15]*=t,this}determinant(){let t=this.elements,e=t[0],i=t[4],r=t[8],s=t[12],a=t[1],o=t[5],h=t[9],l=t[13],c=t[2],u=t[6],d=t[10],f=t[14],p=t[3],m=t[7],g=t[11],_=t[15],y=h*f-l*d,v=o*f-l*u,x=o*d-h*u,w=a*f-l*c,b=a*d-h*c,A=a*u-o*c;return e*(m*y-g*v+_*x)-i*(p*y-g*w+_*b)+r*(p*v-m*w+_*A)-s*(p*x-m*b+g*A)}determinantAffine(){let t=this.elements,e=t[0],i=t[4],r=t[8],s=t[1],a=t[5],o=t[9],h=t[2],l=t[6],c=t[10];return e*(a*c-o*l)-i*(s*c-o*h)+r*(s*l-a*h)}transpose(){let t=this.elements,e;return e=t[1],t[1]=t[4],t[4]=e,e=t[2],t[2]=t[8],t[8]=e,e=t[6],t[6]=t[9],t[9]=e,e=t[3],t[3]=t[12],t[12]=e,e=t[7],t[7]=t[13],t[13]=e,e=t[11],t[11]=t[14],t[14]=e,this}setPosition(t,e,i){let r=this.elements;return t.isVector3?(r[12]=t.x,r[13]=t.y,r[14]=t.z):(r[12]=t,r[13]=e,r[14]=i),this}invert(){let t=this.elements,e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8],u=t[9],d=t[10],f=t[11],p=t[12],m=t[13],g=t[14],_=t[15],y=e*o-i*a,v=e*h-r*a,x=e*l-s*a,w=i*h-r*o,b=i*l-s*o,A=r*l-s*h,I=c*m-u*p,C=c*g-d*p,P=c*_-f*p,L=u*g-d*m,G=u*_-f*m,q=d*_-f*g,V=y*q-v*G+x*L+w*P-b*C+A*I;if(V===0)return this.set(0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0);let B=1/V;return t[0]=(o*q-h*G+l*L)*B,t[1]=(r*G-i*q-s*L)*B,t[2]=(m*A-g*b+_*w)*B,t[3]=(d*b-u*A-f*w)*B,t[4]=(h*P-a*q-l*C)*B,t[5]=(e*q-r*P+s*C)*B,t[6]=(g*x-p*A-_*v)*B,t[7]=(c*A-d*x+f*v)*B,t[8]=(a*G-o*P+l*I)*B,t[9]=(i*P-e*G-s*I)*B,t[10]=(p*b-m*x+_*y)*B,t[11]=(u*x-c*b-f*y)*B,t[12]=(o*C-a*L-h*I)*B,t[13]=(e*L-i*C+r*I)*B,t[14]=(m*v-p*w-g*y)*B,t[15]=(c*w-u*v+d*y)*B,this}scale(t){let e=this.elements,i=t.x,r=t.y,s=t.z;return e[0]*=i,e[4]*=r,e[8]*=s,e[1]*=i,e[5]*=r,e[9]*=s,e[2]*=i,e[6]*=r,e[10]*=s,e[3]*=i,e[7]*=r,e[11]*=s,this}getMaxScaleOnAxis(){let t=this.elements,e=t[0]*t[0]+t[1]*t[1]+t[2]*t[2],i=t[4]*t[4]+t[5]*t[5]+t[6]*t[6],r=t[8]*t[8]+t[9]*t[9]+t[10]*t[10];return Math.sqrt(Math.max(e,i,r))}makeTranslation(t,e,i){return t.isVector3?this.set(1,0,0,t.x,0,1,0,t.y,0,0,1,t.z,0,0,0,1):this.set(1,0,0,t,0,1,0,e,0,0,1,i,0,0,0,1),this}makeRotationX(t){let e=Math.cos(t),i=Math.sin(t);return this.set(1,0,0,0,0,e,-i,0,0,i,e,0,0,0,0,1),this}makeRotationY(t){let e=Math.cos(t),i=Math.sin(t);return this.set(e,0,i,0,0,1,0,0,-i,0,e,0,0,0,0,1),this}makeRotationZ(t){let e=Math.cos(t),i=Math.sin(t);return this.set(e,-i,0,0,i,e,0,0,0,0,1,0,0,0,0,1),this}makeRotationAxis(t,e){let i=Math.cos(e),r=Math.sin(e),s=1-i,a=t.x,o=t.y,h=t.z,l=s*a,c=s*o;return this.set(l*a+i,l*o-r*h,l*h+r*o,0,l*o+r*h,c*o+i,c*h-r*a,0,l*h-r*o,c*h+r*a,s*h*h+i,0,0,0,0,1),this}makeScale(t,e,i){return this.set(t,0,0,0,0,e,0,0,0,0,i,0,0,0,0,1),this}makeShear(t,e,i,r,s,a){return this.set(1,i,s,0,t,1,a,0,e,r,1,0,0,0,0,1),this}compose(t,e,i){let r=this.elements,s=e._x,a=e._y,o=e._z,h=e._w,l=s+s,c=a+a,u=o+o,d=s*l,f=s*c,p=s*u,m=a*c,g=a*u,_=o*u,y=h*l,v=h*c,x=h*u,w=i.x,b=i.y,A=i.z;return r[0]=(1-(m+_))*w,r[1]=(f+x)*w,r[2]=(p-v)*w,r[3]=0,r[4]=(f-x)*b,r[5]=(1-(d+_))*b,r[6]=(g+y)*b,r[7]=0,r[8]=(p+v)*A,r[9]=(g-y)*A,r[10]=(1-(d+m))*A,r[11]=0,r[12]=t.x,r[13]=t.y,r[14]=t.z,r[15]=1,this}decompose(t,e,i){let r=this.elements;t.x=r[12],t.y=r[13],t.z=r[14];let s=this.determinantAffine();if(s===0)return i.set(1,1,1),e.identity(),this;let a=ri.set(r[0],r[1],r[2]).length(),o=ri.set(r[4],r[5],r[6]).length(),h=ri.set(r[8],r[9],r[10]).length();s<0&&(a=-a),Ae.copy(this);let l=1/a,c=1/o,u=1/h;return Ae.elements[0]*=l,Ae.elements[1]*=l,Ae.elements[2]*=l,Ae.elements[4]*=c,Ae.elements[5]*=c,Ae.elements[6]*=c,Ae.elements[8]*=u,Ae.elements[9]*=u,Ae.elements[10]*=u,e.setFromRotationMatrix(Ae),i.x=a,i.y=o,i.z=h,this}makePerspective(t,e,i,r,s,a,o=li,h=!1){let l=this.elements,c=2*s/(e-t),u=2*s/(i-r),d=(e+t)/(e-t),f=(i+r)/(i-r),p,m;if(h)p=s/(a-s),m=a*s/(a-s);else if(o===li)p=-(a+s)/(a-s),m=-2*a*s/(a-s);else if(o===vo)p=-a/(a-s),m=-a*s/(a-s);else throw new Error("THREE.Matrix4.makePerspective(): Invalid coordinate system: "+o);return l[0]=c,l[4]=0,l[8]=d,l[12]=0,l[1]=0,l[5]=u,l[9]=f,l[13]=0,l[2]=0,l[6]=0,l[10]=p,l[14]=m,l[3]=0,l[7]=0,l[11]=-1,l[15]=0,this}makeOrthographic(t,e,i,r,s,a,o=li,h=!1){let l=this.elements,c=2/(e-t),u=2/(i-r),d=-(e+t)/(e-t),f=-(i+r)/(i-r),p,m;if(h)p=1/(a-s),m=a/(a-s);else if(o===li)p=-2/(a-s),m=-(a+s)/(a-s);else if(o===vo)p=-1/(a-s),m=-s/(a-s);else throw new Error("THREE.Matrix4.makeOrthographic(): Invalid coordinate system: "+o);return l[0]=c,l[4]=0,l[8]=0,l[12]=d,l[1]=0,l[5]=u,l[9]=0,l[13]=f,l[2]=0,l[6]=0,l[10]=p,l[14]=m,l[3]=0,l[7]=0,l[11]=0,l[15]=1,this}equals(t){let e=this.elements,i=t.elements;for(let r=0;r<16;r++)if(e[r]!==i[r])return!1;return!0}fromArray(t,e=0){for(let i=0;i<16;i++)this.elements[i]=t[i+e];return this}toArray(t=[],e=0){let i=this.elements;return t[e]=i[0],t[e+1]=i[1],t[e+2]=i[2],t[e+3]=i[3],t[e+4]=i[4],t[e+5]=i[5],t[e+6]=i[6],t[e+7]=i[7],t[e+8]=i[8],t[e+9]=i[9],t[e+10]=i[10],t[e+11]=i[11],t[e+12]=i[12],t[e+13]=i[13],t[e+14]=i[14],t[e+15]=i[15],t}},ri=new st,Ae=new _e,Qm=new st(0,0,0),jm=new st(1,1,1),an=new st,Vr=new st,ae=new st,mc=new _e,gc=new De,Xi=class n{constructor(t=0,e=0,i=0,r=n.DEFAULT_ORDER){this.isEuler=!0,this._x=t,this._y=e,this._z=i,this._order=r}get x(){return this._x}set x(t){this._x=t,this._onChangeCallback()}get y(){return this._y}set y(t){this._y=t,this._onChangeCallback()}get z(){return this._z}set z(t){this._z=t,this._onChangeCallback()}get order(){return this._order}set order(t){this._order=t,this._onChangeCallback()}set(t,e,i,r=this._order){return this._x=t,this._y=e,this._z=i,this._order=r,this._onChangeCallback(),this}clone(){return new this.constructor(this._x,this._y,this._z,this._order)}copy(t){return this._x=t._x,this._y=t._y,this._z=t._z,this._order=t._order,this._onChangeCallback(),this}setFromRotationMatrix(t,e=this._order,i=!0){let r=t.elements,s=r[0],a=r[4],o=r[8],h=r[1],l=r[5],c=r[9],u=r[2],d=r[6],f=r[10];switch(e){case"XYZ":this._y=Math.asin(et(o,-1,1)),Math.abs(o)<.9999999?(this._x=Math.atan2(-c,f),this._z=Math.atan2(-a,s)):(this._x=Math.atan2(d,l),this._z=0);break;case"YXZ":this._x=Math.asin(-et(c,-1,1)),Math.abs(c)<.9999999?(this._y=Math.atan2(o,f),this._z=Math.atan2(h,l)):(this._y=Math.atan2(-u,s),this._z=0);break;case"ZXY":this._x=Math.asin(et(d,-1,1)),Math.abs(d)<.9999999?(this._y=Math.atan2(-u,f),this._z=Math.atan2(-a,l)):(this._y=0,this._z=Math.atan2(h,s));break;case"ZYX":this._y=Math.asin(-et(u,-1,1)),Math.abs(u)<.9999999?(this._x=Math.atan2(d,f),this._z=Math.atan2(h,s)):(this._x=0,this._z=Math.atan2(-a,l));break;case"YZX":this._z=Math.asin(et(h,-1,1)),Math.abs(h)<.9999999?(this._x=Math.atan2(-c,l),this._y=Math.atan2(-u,s)):(this._x=0,this._y=Math.atan2(o,f));break;case"XZY":this._z=Math.asin(-et(a,-1,1)),Math.abs(a)<.9999999?(this._x=Math.atan2(d,l),this._y=Math.atan2(o,s)):(this._x=Math.atan2(-c,f),this._y=0);break;default:Ht("Euler: .setFromRotationMatrix() encountered an unknown order: "+e)}return this._order=e,i===!0&&this._onChangeCallback(),this}setFromQuaternion(t,e,i){return mc.makeRotationFromQuaternion(t),this.setFromRotationMatrix(mc,e,i)}setFromVector3(t,e=this._order){return this.set(t.x,t.y,t.z,e)}reorder(t){return gc.setFromEuler(this),this.setFromQuaternion(gc,t)}equals(t){return t._x===this._x&&t._y===this._y&&t._z===this._z&&t._order===this._order}fromArray(t){return this._x=t[0],this._y=t[1],this._z=t[2],t[3]!==void 0&&(this._order=t[3]),this._onChangeCallback(),this}toArray(t=[],e=0){return t[e]=this._x,t[e+1]=this._y,t[e+2]=this._z,t[e+3]=this._order,t}_onChange(t){return this._onChangeCallback=t,this}_onChangeCallback(){}*[Symbol.iterator](){yield this._x,yield this._y,yield this._z,yield this._order}};Xi.DEFAULT_ORDER="XYZ";var es=class{constructor(){this.mask=1}set(t){this.mask=(1<<t|0)>>>0}enable(t){this.mask|=1<<t|0}enableAll(){this.mask=-1}toggle(t){this.mask^=1<<t|0}disable(t){this.mask&=~(1<<t|0)}disableAll(){this.mask=0}test(t){return(this.mask&t.mask)!==0}isEnabled(t){return(this.mask&(1<<t|0))!==0}},tg=0,_c=new st,si=new De,Ze=new _e,Hr=new st,Bi=new st,eg=new st,ng=new De,xc=new st(1,0,0),vc=new st(0,1,0),yc=new st(0,0,1),Sc={type:"added"},ig={type:"removed"},ai={type:"childadded",child:null},to={type:"childremoved",child:null},En=class n extends Hi{constructor(){super(),this.isObject3D=!0,Object.defineProperty(this,"id",{value:tg++}),this.uuid=fs(),this.name="",this.type="Object3D",this.parent=null,this.children=[],this.up=n.DEFAULT_UP.clone();let t=new st,e=new Xi,i=new De,r=new st(1,1,1);function s(){i.setFromEuler(e,!1)}function a(){e.setFromQuaternion(i,void 0,!1)}e._onChange(s),i._onChange(a),Object.defineProperties(this,{position:{configurable:!0,enumerable:!0,value:t},rotation:{configurable:!0,enumerable:!0,value:e},quaternion:{configurable:!0,enumerable:!0,value:i},scale:{configurable:!0,enumerable:!0,value:r},modelViewMatrix:{value:new _e},normalMatrix:{value:new K}}),this.matrix=new _e,this.matrixWorld=new _e,this.matrixAutoUpdate=n.DEFAULT_MATRIX_AUTO_UPDATE,this.matrixWorldAutoUpdate=n.DEFAULT_MATRIX_WORLD_AUTO_UPDATE,this.matrixWorldNeedsUpdate=!1,this.layers=new es,this.visible=!0,this.castShadow=!1,this.receiveShadow=!1,this.frustumCulled=!0,this.renderOrder=0,this.animations=[],this.customDepthMaterial=void 0,this.customDistanceMaterial=void 0,this.static=!1,this.userData={},this.pivot=null}onBeforeShadow(){}onAfterShadow(){}onBeforeRender(){}onAfterRender(){}applyMatrix4(t){this.matrixAutoUpdate&&this.updateMatrix(),this.matrix.premultiply(t),this.matrix.decompose(this.position,this.quaternion,this.scale),this.pivot!==null&&this.position.copy(this.pivot).applyMatrix4(this.matrix).sub(this.pivot)}applyQuaternion(t){return this.quaternion.premultiply(t),this}setRotationFromAxisAngle(t,e){this.quaternion.setFromAxisAngle(t,e)}setRotationFromEuler(t){this.quaternion.setFromEuler(t,!0)}setRotationFromMatrix(t){this.quaternion.setFromRotationMatrix(t)}setRotationFromQuaternion(t){this.quaternion.copy(t)}rotateOnAxis(t,e){return si.setFromAxisAngle(t,e),this.quaternion.multiply(si),this}rotateOnWorldAxis(t,e){return si.setFromAxisAngle(t,e),this.quaternion.premultiply(si),this}rotateX(t){return this.rotateOnAxis(xc,t)}rotateY(t){return this.rotateOnAxis(vc,t)}rotateZ(t){return this.rotateOnAxis(yc,t)}translateOnAxis(t,e){return _c.copy(t).applyQuaternion(this.quaternion),this.position.add(_c.multiplyScalar(e)),this}translateX(t){return this.translateOnAxis(xc,t)}translateY(t){return this.translateOnAxis(vc,t)}translateZ(t){return this.translateOnAxis(yc,t)}localToWorld(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(this.matrixWorld)}worldToLocal(t){return this.updateWorldMatrix(!0,!1),t.applyMatrix4(Ze.copy(this.matrixWorld).invert())}lookAt(t,e,i){t.isVector3?Hr.copy(t):Hr.set(t,e,i);let r=this.parent;this.updateWorldMatrix(!0,!1),Bi.setFromMatrixPosition(this.matrixWorld),this.isCamera||this.isLight?Ze.lookAt(Bi,Hr,this.up):Ze.lookAt(Hr,Bi,this.up),this.quaternion.setFromRotationMatrix(Ze),r&&(Ze.extractRotation(r.matrixWorld),si.setFromRotationMatrix(Ze),this.quaternion.premultiply(si.invert()))}add(t){if(arguments.length>1){for(let e=0;e<arguments.length;e++)this.add(arguments[e]);return this}return t===this?(Ut("Object3D.add: object can't be added as a child of itself.",t),this):(t&&t.isObject3D?(t.removeFromParent(),t.parent=this,this.children.push(t),t.dispatchEvent(Sc),ai.child=t,this.dispatchEvent(ai),ai.child=null):Ut("Object3D.add: object not an instance of THREE.Object3D.",t),this)}remove(t){if(arguments.length>1){for(let i=0;i<arguments.length;i++)this.remove(arguments[i]);return this}let e=this.children.indexOf(t);return e!==-1&&(t.parent=null,this.children.splice(e,1),t.dispatchEvent(ig),to.child=t,this.dispatchEvent(to),to.child=null),this}removeFromParent(){let t=this.parent;return t!==null&&t.remove(this),this}clear(){return this.remove(...this.children)}attach(t){return this.updateWorldMatrix(!0,!1),Ze.copy(this.matrixWorld).invert(),t.parent!==null&&(t.parent.updateWorldMatrix(!0,!1),Ze.multiply(t.parent.matrixWorld)),t.applyMatrix4(Ze),t.removeFromParent(),t.parent=this,this.children.push(t),t.updateWorldMatrix(!1,!0),t.dispatchEvent(Sc),ai.child=t,this.dispatchEvent(ai),ai.child=null,this}getObjectById(t){return this.getObjectByProperty("id",t)}getObjectByName(t){return this.getObjectByProperty("name",t)}getObjectByProperty(t,e){if(this[t]===e)return this;for(let i=0,r=this.children.length;i<r;i++){let a=this.children[i].getObjectByProperty(t,e);if(a!==void 0)return a}}getObjectsByProperty(t,e,i=[]){this[t]===e&&i.push(this);let r=this.children;for(let s=0,a=r.length;s<a;s++)r[s].getObjectsByProperty(t,e,i);return i}getWorldPosition(t){return this.updateWorldMatrix(!0,!1),t.setFromMatrixPosition(this.matrixWorld)}getWorldQuaternion(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(Bi,t,eg),t}getWorldScale(t){return this.updateWorldMatrix(!0,!1),this.matrixWorld.decompose(Bi,ng,t),t}getWorldDirection(t){this.updateWorldMatrix(!0,!1);let e=this.matrixWorld.elements;return t.set(e[8],e[9],e[10]).normalize()}raycast(){}intersectsFrustum(){return!0}traverse(t){t(this);let e=this.children;for(let i=0,r=e.length;i<r;i++)e[i].traverse(t)}traverseVisible(t){if(this.visible===!1)return;t(this);let e=this.children;for(let i=0,r=e.length;i<r;i++)e[i].traverseVisible(t)}traverseAncestors(t){let e=this.parent;e!==null&&(t(e),e.traverseAncestors(t))}updateMatrix(){this.matrix.compose(this.position,this.quaternion,this.scale);let t=this.pivot;if(t!==null){let e=t.x,i=t.y,r=t.z,s=this.matrix.elements;s[12]+=e-s[0]*e-s[4]*i-s[8]*r,s[13]+=i-s[1]*e-s[5]*i-s[9]*r,s[14]+=r-s[2]*e-s[6]*i-s[10]*r}this.matrixWorldNeedsUpdate=!0}updateMatrixWorld(t){this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||t)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,t=!0);let e=this.children;for(let i=0,r=e.length;i<r;i++)e[i].updateMatrixWorld(t)}updateWorldMatrix(t,e,i=!1){let r=this.parent;if(t===!0&&r!==null&&r.updateWorldMatrix(!0,!1),this.matrixAutoUpdate&&this.updateMatrix(),(this.matrixWorldNeedsUpdate||i)&&(this.matrixWorldAutoUpdate===!0&&(this.parent===null?this.matrixWorld.copy(this.matrix):this.matrixWorld.multiplyMatrices(this.parent.matrixWorld,this.matrix)),this.matrixWorldNeedsUpdate=!1,i=!0),e===!0){let s=this.children;for(let a=0,o=s.length;a<o;a++)s[a].updateWorldMatrix(!1,!0,i)}}toJSON(t){let e=t===void 0||typeof t=="string",i={};e&&(t={geometries:{},materials:{},textures:{},images:{},shapes:{},skeletons:{},animations:{},nodes:{}},i.metadata={version:4.7,type:"Object",generator:"Object3D.toJSON"});let r={};r.uuid=this.uuid,r.type=this.type,r.name=this.name,r.castShadow=this.castShadow,r.receiveShadow=this.receiveShadow,r.visible=this.visible,r.frustumCulled=this.frustumCulled,r.renderOrder=this.renderOrder,r.static=this.static,r.matrixAutoUpdate=this.matrixAutoUpdate,Object.keys(this.userData).length>0&&(r.userData=this.userData),r.layers=this.layers.mask,r.matrix=this.matrix.toArray(),r.up=this.up.toArray(),this.pivot!==null&&(r.pivot=this.pivot.toArray()),this.morphTargetDictionary!==void 0&&(r.morphTargetDictionary=Object.assign({},this.morphTargetDictionary)),this.morphTargetInfluences!==void 0&&(r.morphTargetInfluences=this.morphTargetInfluences.slice()),this.isInstancedMesh&&(r.type="InstancedMesh",r.count=this.count,r.instanceMatrix=this.instanceMatrix.toJSON(),this.instanceColor!==null&&(r.instanceColor=this.instanceColor.toJSON())),this.isBatchedMesh&&(r.type="BatchedMesh",r.perObjectFrustumCulled=this.perObjectFrustumCulled,r.sortObjects=this.sortObjects,r.drawRanges=this._drawRanges,r.reservedRanges=this._reservedRanges,r.geometryInfo=this._geometryInfo.map(o=>({...o,boundingBox:o.boundingBox?o.boundingBox.toJSON():void 0,boundingSphere:o.boundingSphere?o.boundingSphere.toJSON():void 0})),r.instanceInfo=this._instanceInfo.map(o=>({...o})),r.availableInstanceIds=this._availableInstanceIds.slice(),r.availableGeometryIds=this._availableGeometryIds.slice(),r.nextIndexStart=this._nextIndexStart,r.nextVertexStart=this._nextVertexStart,r.geometryCount=this._geometryCount,r.maxInstanceCount=this._maxInstanceCount,r.maxVertexCount=this._maxVertexCount,r.maxIndexCount=this._maxIndexCount,r.geometryInitialized=this._geometryInitialized,r.matricesTexture=this._matricesTexture.toJSON(t),r.indirectTexture=this._indirectTexture.toJSON(t),this._colorsTexture!==null&&(r.colorsTexture=this._colorsTexture.toJSON(t)),this.boundingSphere!==null&&(r.boundingSphere=this.boundingSphere.toJSON()),this.boundingBox!==null&&(r.boundingBox=this.boundingBox.toJSON()));function s(o,h){return o[h.uuid]===void 0&&(o[h.uuid]=h.toJSON(t)),h.uuid}if(this.isScene)this.background&&(this.background.isColor?r.background=this.background.toJSON():this.background.isTexture&&(r.background=this.background.toJSON(t).uuid)),this.environment&&this.environment.isTexture&&this.environment.isRenderTargetTexture!==!0&&(r.environment=this.environment.toJSON(t).uuid);else if(this.isMesh||this.isLine||this.isPoints){r.geometry=s(t.geometries,this.geometry);let o=this.geometry.parameters;if(o!==void 0&&o.shapes!==void 0){let h=o.shapes;if(Array.isArray(h))for(let l=0,c=h.length;l<c;l++){let u=h[l];s(t.shapes,u)}else s(t.shapes,h)}}if(this.isSkinnedMesh&&(r.bindMode=this.bindMode,r.bindMatrix=this.bindMatrix.toArray(),this.skeleton!==void 0&&(s(t.skeletons,this.skeleton),r.skeleton=this.skeleton.uuid)),this.material!==void 0)if(Array.isArray(this.material)){let o=[];for(let h=0,l=this.material.length;h<l;h++)o.push(s(t.materials,this.material[h]));r.material=o}else r.material=s(t.materials,this.material);if(this.children.length>0){r.children=[];for(let o=0;o<this.children.length;o++)r.children.push(this.children[o].toJSON(t).object)}if(this.animations.length>0){r.animations=[];for(let o=0;o<this.animations.length;o++){let h=this.animations[o];r.animations.push(s(t.animations,h))}}if(e){let o=a(t.geometries),h=a(t.materials),l=a(t.textures),c=a(t.images),u=a(t.shapes),d=a(t.skeletons),f=a(t.animations),p=a(t.nodes);o.length>0&&(i.geometries=o),h.length>0&&(i.materials=h),l.length>0&&(i.textures=l),c.length>0&&(i.images=c),u.length>0&&(i.shapes=u),d.length>0&&(i.skeletons=d),f.length>0&&(i.animations=f),p.length>0&&(i.nodes=p)}return i.object=r,i;function a(o){let h=[];for(let l in o){let c=o[l];delete c.metadata,h.push(c)}return h}}clone(t){return new this.constructor().copy(this,t)}copy(t,e=!0){if(this.name=t.name,this.up.copy(t.up),this.position.copy(t.position),this.rotation.order=t.rotation.order,this.quaternion.copy(t.quaternion),this.scale.copy(t.scale),this.pivot=t.pivot!==null?t.pivot.clone():null,this.matrix.copy(t.matrix),this.matrixWorld.copy(t.matrixWorld),this.matrixAutoUpdate=t.matrixAutoUpdate,this.matrixWorldAutoUpdate=t.matrixWorldAutoUpdate,this.matrixWorldNeedsUpdate=t.matrixWorldNeedsUpdate,this.layers.mask=t.layers.mask,this.visible=t.visible,this.castShadow=t.castShadow,this.receiveShadow=t.receiveShadow,this.frustumCulled=t.frustumCulled,this.renderOrder=t.renderOrder,this.static=t.static,this.animations=t.animations.slice(),this.userData=JSON.parse(JSON.stringify(t.userData)),e===!0)for(let i=0;i<t.children.length;i++){let r=t.children[i];this.add(r.clone())}return this}dispose(){this.dispatchEvent({type:"dispose"})}};En.DEFAULT_UP=new st(0,1,0);En.DEFAULT_MATRIX_AUTO_UPDATE=!0;En.DEFAULT_MATRIX_WORLD_AUTO_UPDATE=!0;var kc={aliceblue:15792383,antiquewhite:16444375,aqua:65535,aquamarine:8388564,azure:15794175,beige:16119260,bisque:16770244,black:0,blanchedalmond:16772045,blue:255,blueviolet:9055202,brown:10824234,burlywood:14596231,cadetblue:6266528,chartreuse:8388352,chocolate:13789470,coral:16744272,cornflowerblue:6591981,cornsilk:16775388,crimson:14423100,cyan:65535,darkblue:139,darkcyan:35723,darkgoldenrod:12092939,darkgray:11119017,darkgreen:25600,darkgrey:11119017,darkkhaki:12433259,darkmagenta:9109643,darkolivegreen:5597999,darkorange:16747520,darkorchid:10040012,darkred:9109504,darksalmon:15308410,darkseagreen:9419919,darkslateblue:4734347,darkslategray:3100495,darkslategrey:3100495,darkturquoise:52945,darkviolet:9699539,deeppink:16716947,deepskyblue:49151,dimgray:6908265,dimgrey:6908265,dodgerblue:2003199,firebrick:11674146,floralwhite:16775920,forestgreen:2263842,fuchsia:16711935,gainsboro:14474460,ghostwhite:16316671,gold:16766720,goldenrod:14329120,gray:8421504,green:32768,greenyellow:11403055,grey:8421504,honeydew:15794160,hotpink:16738740,indianred:13458524,indigo:4915330,ivory:16777200,khaki:15787660,lavender:15132410,lavenderblush:16773365,lawngreen:8190976,lemonchiffon:16775885,lightblue:11393254,lightcoral:15761536,lightcyan:14745599,lightgoldenrodyellow:16448210,lightgray:13882323,lightgreen:9498256,lightgrey:13882323,lightpink:16758465,lightsalmon:16752762,lightseagreen:2142890,lightskyblue:8900346,lightslategray:7833753,lightslategrey:7833753,lightsteelblue:11584734,lightyellow:16777184,lime:65280,limegreen:3329330,linen:16445670,magenta:16711935,maroon:8388608,mediumaquamarine:6737322,mediumblue:205,mediumorchid:12211667,mediumpurple:9662683,mediumseagreen:3978097,mediumslateblue:8087790,mediumspringgreen:64154,mediumturquoise:4772300,mediumvioletred:13047173,midnightblue:1644912,mintcream:16121850,mistyrose:16770273,moccasin:16770229,navajowhite:16768685,navy:128,oldlace:16643558,olive:8421376,olivedrab:7048739,orange:16753920,orangered:16729344,orchid:14315734,palegoldenrod:15657130,palegreen:10025880,paleturquoise:11529966,palevioletred:14381203,papayawhip:16773077,peachpuff:16767673,peru:13468991,pink:16761035,plum:14524637,powderblue:11591910,purple:8388736,rebeccapurple:6697881,red:16711680,rosybrown:12357519,royalblue:4286945,saddlebrown:9127187,salmon:16416882,sandybrown:16032864,seagreen:3050327,seashell:16774638,sienna:10506797,silver:12632256,skyblue:8900331,slateblue:6970061,slategray:7372944,slategrey:7372944,snow:16775930,springgreen:65407,steelblue:4620980,tan:13808780,teal:32896,thistle:14204888,tomato:16737095,turquoise:4251856,violet:15631086,wheat:16113331,white:16777215,whitesmoke:16119285,yellow:16776960,yellowgreen:10145074},on={h:0,s:0,l:0},Wr={h:0,s:0,l:0};function eo(n,t,e){return e<0&&(e+=1),e>1&&(e-=1),e<1/6?n+(t-n)*6*e:e<1/2?t:e<2/3?n+(t-n)*6*(2/3-e):n}var Ft=class{constructor(t,e,i){return this.isColor=!0,this.r=1,this.g=1,this.b=1,this.set(t,e,i)}set(t,e,i){if(e===void 0&&i===void 0){let r=t;r&&r.isColor?this.copy(r):typeof r=="number"?this.setHex(r):typeof r=="string"&&this.setStyle(r)}else this.setRGB(t,e,i);return this}setScalar(t){return this.r=t,this.g=t,this.b=t,this}setHex(t,e=ge){return t=Math.floor(t),this.r=(t>>16&255)/255,this.g=(t>>8&255)/255,this.b=(t&255)/255,me.colorSpaceToWorking(this,e),this}setRGB(t,e,i,r=me.workingColorSpace){return this.r=t,this.g=e,this.b=i,me.colorSpaceToWorking(this,r),this}setHSL(t,e,i,r=me.workingColorSpace){if(t=Lo(t,1),e=et(e,0,1),i=et(i,0,1),e===0)this.r=this.g=this.b=i;else{let s=i<=.5?i*(1+e):i+e-i*e,a=2*i-s;this.r=eo(a,s,t+1/3),this.g=eo(a,s,t),this.b=eo(a,s,t-1/3)}return me.colorSpaceToWorking(this,r),this}setStyle(t,e=ge){function i(s){s!==void 0&&parseFloat(s)<1&&Ht("Color: Alpha component of "+t+" will be ignored.")}let r;if(r=/^(\w+)\(([^\)]*)\)/.exec(t)){let s,a=r[1],o=r[2];switch(a){case"rgb":case"rgba":if(s=/^\s*(\d+)\s*,\s*(\d+)\s*,\s*(\d+)\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(o))return i(s[4]),this.setRGB(Math.min(255,parseInt(s[1],10))/255,Math.min(255,parseInt(s[2],10))/255,Math.min(255,parseInt(s[3],10))/255,e);if(s=/^\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(o))return i(s[4]),this.setRGB(Math.min(100,parseFloat(s[1]))/100,Math.min(100,parseFloat(s[2]))/100,Math.min(100,parseFloat(s[3]))/100,e);break;case"hsl":case"hsla":if(s=/^\s*([+-]?(?:\d+(?:\.\d+)?|\.\d+))\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*,\s*(\d+(?:\.\d+)?|\.\d+)\%\s*(?:,\s*(\d+(?:\.\d+)?|\.\d+)\s*)?$/.exec(o))return i(s[4]),this.setHSL(parseFloat(s[1])/360,parseFloat(s[2])/100,parseFloat(s[3])/100,e);break;default:Ht("Color: Unknown color model "+t)}}else if(r=/^\#([A-Fa-f\d]+)$/.exec(t)){let s=r[1],a=s.length;if(a===3)return this.setRGB(parseInt(s.charAt(0),16)/15,parseInt(s.charAt(1),16)/15,parseInt(s.charAt(2),16)/15,e);if(a===6)return this.setHex(parseInt(s,16),e);Ht("Color: Invalid hex color "+t)}else if(t&&t.length>0)return this.setColorName(t,e);return this}setColorName(t,e=ge){let i=kc[t.toLowerCase()];return i!==void 0?this.setHex(i,e):Ht("Color: Unknown color "+t),this}clone(){return new this.constructor(this.r,this.g,this.b)}copy(t){return this.r=t.r,this.g=t.g,this.b=t.b,this}copySRGBToLinear(t){return this.r=Je(t.r),this.g=Je(t.g),this.b=Je(t.b),this}copyLinearToSRGB(t){return this.r=ci(t.r),this.g=ci(t.g),this.b=ci(t.b),this}convertSRGBToLinear(){return this.copySRGBToLinear(this),this}convertLinearToSRGB(){return this.copyLinearToSRGB(this),this}getHex(t=ge){return me.workingToColorSpace(Qt.copy(this),t),Math.round(et(Qt.r*255,0,255))*65536+Math.round(et(Qt.g*255,0,255))*256+Math.round(et(Qt.b*255,0,255))}getHexString(t=ge){return("000000"+this.getHex(t).toString(16)).slice(-6)}getHSL(t,e=me.workingColorSpace){me.workingToColorSpace(Qt.copy(this),e);let i=Qt.r,r=Qt.g,s=Qt.b,a=Math.max(i,r,s),o=Math.min(i,r,s),h,l,c=(o+a)/2;if(o===a)h=0,l=0;else{let u=a-o;switch(l=c<=.5?u/(a+o):u/(2-a-o),a){case i:h=(r-s)/u+(r<s?6:0);break;case r:h=(s-i)/u+2;break;case s:h=(i-r)/u+4;break}h/=6}return t.h=h,t.s=l,t.l=c,t}getRGB(t,e=me.workingColorSpace){return me.workingToColorSpace(Qt.copy(this),e),t.r=Qt.r,t.g=Qt.g,t.b=Qt.b,t}getStyle(t=ge){me.workingToColorSpace(Qt.copy(this),t);let e=Qt.r,i=Qt.g,r=Qt.b;return t!==ge?`color(${t} ${e.toFixed(3)} ${i.toFixed(3)} ${r.toFixed(3)})`:`rgb(${Math.round(e*255)},${Math.round(i*255)},${Math.round(r*255)})`}offsetHSL(t,e,i){return this.getHSL(on),this.setHSL(on.h+t,on.s+e,on.l+i)}add(t){return this.r+=t.r,this.g+=t.g,this.b+=t.b,this}addColors(t,e){return this.r=t.r+e.r,this.g=t.g+e.g,this.b=t.b+e.b,this}addScalar(t){return this.r+=t,this.g+=t,this.b+=t,this}sub(t){return this.r=Math.max(0,this.r-t.r),this.g=Math.max(0,this.g-t.g),this.b=Math.max(0,this.b-t.b),this}multiply(t){return this.r*=t.r,this.g*=t.g,this.b*=t.b,this}multiplyScalar(t){return this.r*=t,this.g*=t,this.b*=t,this}lerp(t,e){return this.r+=(t.r-this.r)*e,this.g+=(t.g-this.g)*e,this.b+=(t.b-this.b)*e,this}lerpColors(t,e,i){return this.r=t.r+(e.r-t.r)*i,this.g=t.g+(e.g-t.g)*i,this.b=t.b+(e.b-t.b)*i,this}lerpHSL(t,e){this.getHSL(on),t.getHSL(Wr);let i=Gi(on.h,Wr.h,e),r=Gi(on.s,Wr.s,e),s=Gi(on.l,Wr.l,e);return this.setHSL(i,r,s),this}setFromVector3(t){return this.r=t.x,this.g=t.y,this.b=t.z,this}applyMatrix3(t){let e=this.r,i=this.g,r=this.b,s=t.elements;return this.r=s[0]*e+s[3]*i+s[6]*r,this.g=s[1]*e+s[4]*i+s[7]*r,this.b=s[2]*e+s[5]*i+s[8]*r,this}equals(t){return t.r===this.r&&t.g===this.g&&t.b===this.b}fromArray(t,e=0){return this.r=t[e],this.g=t[e+1],this.b=t[e+2],this}toArray(t=[],e=0){return t[e]=this.r,t[e+1]=this.g,t[e+2]=this.b,t}fromBufferAttribute(t,e){return this.r=t.getX(e),this.g=t.getY(e),this.b=t.getZ(e),this}toJSON(){return this.getHex()}*[Symbol.iterator](){yield this.r,yield this.g,yield this.b}},Qt=new Ft;Ft.NAMES=kc;function Gc(n){let t={};for(let e in n){t[e]={};for(let i in n[e]){let r=n[e][i];if(Mc(r))r.isRenderTargetTexture?(Ht("UniformsUtils: Textures of render targets cannot be cloned via cloneUniforms() or mergeUniforms()."),t[e][i]=null):t[e][i]=r.clone();else if(Array.isArray(r))if(Mc(r[0])){let s=[];for(let a=0,o=r.length;a<o;a++)s[a]=r[a].clone();t[e][i]=s}else t[e][i]=r.slice();else t[e][i]=r}}return t}function ee(n){let t={};for(let e=0;e<n.length;e++){let i=Gc(n[e]);for(let r in i)t[r]=i[r]}return t}function Mc(n){return n&&(n.isColor||n.isMatrix3||n.isMatrix4||n.isVector2||n.isVector3||n.isVector4||n.isTexture||n.isQuaternion)}function oi(n,t){return!n||n.constructor===t?n:typeof t.BYTES_PER_ELEMENT=="number"?new t(n):Array.prototype.slice.call(n)}function Xr(n){return n!==void 0&&n.inTangents!==void 0&&n.outTangents!==void 0}var cn=class{constructor(t,e,i,r){this.parameterPositions=t,this._cachedIndex=0,this.resultBuffer=r!==void 0?r:new e.constructor(i),this.sampleValues=e,this.valueSize=i,this.settings=null,this.DefaultSettings_={}}evaluate(t){let e=this.parameterPositions,i=this._cachedIndex,r=e[i],s=e[i-1];t:{e:{let a;n:{i:if(!(t<r)){for(let o=i+2;;){if(r===void 0){if(t<s)break i;return i=e.length,this._cachedIndex=i,this.copySampleValue_(i-1)}if(i===o)break;if(s=r,r=e[++i],t<r)break e}a=e.length;break n}if(!(t>=s)){let o=e[1];t<o&&(i=2,s=o);for(let h=i-2;;){if(s===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(i===h)break;if(r=s,s=e[--i-1],t>=s)break e}a=i,i=0;break n}break t}for(;i<a;){let o=i+a>>>1;t<e[o]?a=o:i=o+1}if(r=e[i],s=e[i-1],s===void 0)return this._cachedIndex=0,this.copySampleValue_(0);if(r===void 0)return i=e.length,this._cachedIndex=i,this.copySampleValue_(i-1)}this._cachedIndex=i,this.intervalChanged_(i,s,r)}return this.interpolate_(i,s,t,r)}getSettings_(){return this.settings||this.DefaultSettings_}copySampleValue_(t){let e=this.resultBuffer,i=this.sampleValues,r=this.valueSize,s=t*r;for(let a=0;a!==r;++a)e[a]=i[s+a];return e}interpolate_(){throw new Error("THREE.Interpolant: Call to abstract method.")}intervalChanged_(){}},ns=class extends cn{constructor(t,e,i,r){super(t,e,i,r),this._weightPrev=-0,this._offsetPrev=-0,this._weightNext=-0,this._offsetNext=-0,this.DefaultSettings_={endingStart:po,endingEnd:po}}intervalChanged_(t,e,i){let r=this.parameterPositions,s=t-2,a=t+1,o=r[s],h=r[a];if(o===void 0)switch(this.getSettings_().endingStart){case mo:s=t,o=2*e-i;break;case go:s=r.length-2,o=e+r[s]-r[s+1];break;default:s=t,o=i}if(h===void 0)switch(this.getSettings_().endingEnd){case mo:a=t,h=2*i-e;break;case go:a=1,h=i+r[1]-r[0];break;default:a=t-1,h=e}let l=(i-e)*.5,c=this.valueSize;this._weightPrev=l/(e-o),this._weightNext=l/(h-i),this._offsetPrev=s*c,this._offsetNext=a*c}interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=t*o,l=h-o,c=this._offsetPrev,u=this._offsetNext,d=this._weightPrev,f=this._weightNext,p=(i-e)/(r-e),m=p*p,g=m*p,_=-d*g+2*d*m-d*p,y=(1+d)*g+(-1.5-2*d)*m+(-.5+d)*p+1,v=(-1-f)*g+(1.5+f)*m+.5*p,x=f*g-f*m;for(let w=0;w!==o;++w)s[w]=_*a[c+w]+y*a[l+w]+v*a[h+w]+x*a[u+w];return s}},is=class extends cn{constructor(t,e,i,r){super(t,e,i,r)}interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=t*o,l=h-o,c=(i-e)/(r-e),u=1-c;for(let d=0;d!==o;++d)s[d]=a[l+d]*u+a[h+d]*c;return s}},rs=class extends cn{constructor(t,e,i,r){super(t,e,i,r)}interpolate_(t){return this.copySampleValue_(t-1)}},ss=class extends cn{interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=t*o,l=h-o,c=this.inTangents,u=this.outTangents;if(!c||!u){let p=(i-e)/(r-e),m=1-p;for(let g=0;g!==o;++g)s[g]=a[l+g]*m+a[h+g]*p;return s}let d=o*2,f=t-1;for(let p=0;p!==o;++p){let m=a[l+p],g=a[h+p],_=f*d+p*2,y=u[_],v=u[_+1],x=t*d+p*2,w=c[x],b=c[x+1],A=sg(i,e,y,w,r);s[p]=Vc(A,m,v,b,g)}return s}};function Vc(n,t,e,i,r){let s=1-n;return s*s*s*t+3*s*s*n*e+3*s*n*n*i+n*n*n*r}function rg(n,t,e,i,r){let s=1-n;return 3*s*s*(e-t)+6*s*n*(i-e)+3*n*n*(r-i)}function sg(n,t,e,i,r){let s=(n-t)/(r-t);for(let a=0;a<8;a++){let o=Vc(s,t,e,i,r)-n;if(Math.abs(o)<1e-10)break;let h=rg(s,t,e,i,r);if(Math.abs(h)<1e-10)break;s=Math.max(0,Math.min(1,s-o/h))}return s}var le=class{constructor(t,e,i,r){if(t===void 0)throw new Error("THREE.KeyframeTrack: track name is undefined");if(e===void 0||e.length===0)throw new Error("THREE.KeyframeTrack: no keyframes in track named "+t);this.name=t,this.times=oi(e,this.TimeBufferType),this.values=oi(i,this.ValueBufferType),this.setInterpolation(r||this.DefaultInterpolation)}static toJSON(t){let e=t.constructor,i;if(e.toJSON!==this.toJSON)i=e.toJSON(t);else{i={name:t.name,times:oi(t.times,Array),values:oi(t.values,Array)};let r=t.getInterpolation();r!==t.DefaultInterpolation&&(i.interpolation=r),Xr(t.settings)&&(i.settings={inTangents:oi(t.settings.inTangents,Array),outTangents:oi(t.settings.outTangents,Array)})}return i.type=t.ValueTypeName,i}InterpolantFactoryMethodDiscrete(t){return new rs(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodLinear(t){return new is(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodSmooth(t){return new ns(this.times,this.values,this.getValueSize(),t)}InterpolantFactoryMethodBezier(t){let e=new ss(this.times,this.values,this.getValueSize(),t);return this.settings&&(e.inTangents=this.settings.inTangents,e.outTangents=this.settings.outTangents),e}setInterpolation(t){let e;switch(t){case Vi:e=this.InterpolantFactoryMethodDiscrete;break;case Kr:e=this.InterpolantFactoryMethodLinear;break;case Zr:e=this.InterpolantFactoryMethodSmooth;break;case fo:e=this.InterpolantFactoryMethodBezier;break}if(e===void 0){let i="unsupported interpolation for "+this.ValueTypeName+" keyframe track named "+this.name;if(this.createInterpolant===void 0)if(t!==this.DefaultInterpolation)this.setInterpolation(this.DefaultInterpolation);else throw new Error(i);return Ht("KeyframeTrack:",i),this}return this.createInterpolant=e,this}getInterpolation(){switch(this.createInterpolant){case this.InterpolantFactoryMethodDiscrete:return Vi;case this.InterpolantFactoryMethodLinear:return Kr;case this.InterpolantFactoryMethodSmooth:return Zr;case this.InterpolantFactoryMethodBezier:return fo}}getValueSize(){return this.values.length/this.times.length}shift(t){if(t!==0){let e=this.times;for(let i=0,r=e.length;i!==r;++i)e[i]+=t;Xr(this.settings)&&(bc(this.settings.inTangents,t),bc(this.settings.outTangents,t))}return this}scale(t){if(t!==1){let e=this.times;for(let i=0,r=e.length;i!==r;++i)e[i]*=t;Xr(this.settings)&&(wc(this.settings.inTangents,t),wc(this.settings.outTangents,t))}return this}trim(t,e){let i=this.times,r=i.length,s=0,a=r-1;for(;s!==r&&i[s]<t;)++s;for(;a!==-1&&i[a]>e;)--a;if(++a,s!==0||a!==r){s>=a&&(a=Math.max(a,1),s=a-1);let o=this.getValueSize();this.times=i.slice(s,a),this.values=this.values.slice(s*o,a*o)}return this}validate(){let t=!0,e=this.getValueSize();e-Math.floor(e)!==0&&(Ut("KeyframeTrack: Invalid value size in track.",this),t=!1);let i=this.times,r=this.values,s=i.length;s===0&&(Ut("KeyframeTrack: Track is empty.",this),t=!1);let a=null;for(let o=0;o!==s;o++){let h=i[o];if(typeof h=="number"&&isNaN(h)){Ut("KeyframeTrack: Time is not a valid number.",this,o,h),t=!1;break}if(a!==null&&a>h){Ut("KeyframeTrack: Out of order keys.",this,o,h,a),t=!1;break}a=h}if(r!==void 0&&Im(r))for(let o=0,h=r.length;o!==h;++o){let l=r[o];if(isNaN(l)){Ut("KeyframeTrack: Value is not a valid number.",this,o,l),t=!1;break}}return t}optimize(){let t=this.times.slice(),e=this.values.slice(),i=this.getValueSize(),r=this.getInterpolation()===Zr,s=t.length-1,a=1;for(let o=1;o<s;++o){let h=!1,l=t[o],c=t[o+1];if(l!==c&&(o!==1||l!==t[0]))if(r)h=!0;else{let u=o*i,d=u-i,f=u+i;for(let p=0;p!==i;++p){let m=e[u+p];if(m!==e[d+p]||m!==e[f+p]){h=!0;break}}}if(h){if(o!==a){t[a]=t[o];let u=o*i,d=a*i;for(let f=0;f!==i;++f)e[d+f]=e[u+f]}++a}}if(s>0){t[a]=t[s];for(let o=s*i,h=a*i,l=0;l!==i;++l)e[h+l]=e[o+l];++a}return a!==t.length?(this.times=t.slice(0,a),this.values=e.slice(0,a*i)):(this.times=t,this.values=e),this}clone(){let t=this.times.slice(),e=this.values.slice(),i=this.constructor,r=new i(this.name,t,e);return r.createInterpolant=this.createInterpolant,Xr(this.settings)&&(r.settings={inTangents:this.settings.inTangents.slice(),outTangents:this.settings.outTangents.slice()}),r}};function bc(n,t){for(let e=0,i=n.length;e!==i;e+=2)n[e]+=t}function wc(n,t){for(let e=0,i=n.length;e!==i;e+=2)n[e]*=t}le.prototype.ValueTypeName="";le.prototype.TimeBufferType=Float32Array;le.prototype.ValueBufferType=Float32Array;le.prototype.DefaultInterpolation=Kr;var hn=class extends le{constructor(t,e,i){super(t,e,i)}};hn.prototype.ValueTypeName="bool";hn.prototype.ValueBufferType=Array;hn.prototype.DefaultInterpolation=Vi;hn.prototype.InterpolantFactoryMethodLinear=void 0;hn.prototype.InterpolantFactoryMethodSmooth=void 0;var as=class extends le{constructor(t,e,i,r){super(t,e,i,r)}};as.prototype.ValueTypeName="color";var os=class extends le{constructor(t,e,i,r){super(t,e,i,r)}};os.prototype.ValueTypeName="number";var ls=class extends cn{constructor(t,e,i,r){super(t,e,i,r)}interpolate_(t,e,i,r){let s=this.resultBuffer,a=this.sampleValues,o=this.valueSize,h=(i-e)/(r-e),l=t*o;for(let c=l+o;l!==c;l+=4)De.slerpFlat(s,0,a,l-o,a,l,h);return s}},qi=class extends le{constructor(t,e,i,r){super(t,e,i,r)}InterpolantFactoryMethodLinear(t){return new ls(this.times,this.values,this.getValueSize(),t)}};qi.prototype.ValueTypeName="quaternion";qi.prototype.InterpolantFactoryMethodSmooth=void 0;var un=class extends le{constructor(t,e,i){super(t,e,i)}};un.prototype.ValueTypeName="string";un.prototype.ValueBufferType=Array;un.prototype.DefaultInterpolation=Vi;un.prototype.InterpolantFactoryMethodLinear=void 0;un.prototype.InterpolantFactoryMethodSmooth=void 0;var cs=class extends le{constructor(t,e,i,r){super(t,e,i,r)}};cs.prototype.ValueTypeName="vector";var hs=class{constructor(t,e,i){let r=this,s=!1,a=0,o=0,h,l=[];this.onStart=void 0,this.onLoad=t,this.onProgress=e,this.onError=i,this._abortController=null,this.itemStart=function(c){o++,s===!1&&r.onStart!==void 0&&r.onStart(c,a,o),s=!0},this.itemEnd=function(c){a++,r.onProgress!==void 0&&r.onProgress(c,a,o),a===o&&(s=!1,r.onLoad!==void 0&&r.onLoad())},this.itemError=function(c){r.onError!==void 0&&r.onError(c)},this.resolveURL=function(c){return c=c.normalize("NFC"),h?h(c):c},this.setURLModifier=function(c){return h=c,this},this.addHandler=function(c,u){return l.push(c,u),this},this.removeHandler=function(c){let u=l.indexOf(c);return u!==-1&&l.splice(u,2),this},this.getHandler=function(c){for(let u=0,d=l.length;u<d;u+=2){let f=l[u],p=l[u+1];if(f.global&&(f.lastIndex=0),f.test(c))return p}return null},this.abort=function(){return this.abortController.abort(),this._abortController=null,this}}get abortController(){return this._abortController||(this._abortController=new AbortController),this._abortController}},Hc=new hs,us=class{constructor(t){this.manager=t!==void 0?t:Hc,this.crossOrigin="anonymous",this.withCredentials=!1,this.path="",this.resourcePath="",this.requestHeader={},this.priority="auto",this.cache="default",typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("observe",{detail:this}))}load(){}loadAsync(t,e){let i=this;return new Promise(function(r,s){i.load(t,r,e,s)})}parse(){}setCrossOrigin(t){return this.crossOrigin=t,this}setWithCredentials(t){return this.withCredentials=t,this}setPath(t){return this.path=t,this}setResourcePath(t){return this.resourcePath=t,this}setRequestHeader(t){return this.requestHeader=t,this}setPriority(t){return this.priority=t,this}setCache(t){return this.cache=t,this}abort(){return this}};us.DEFAULT_MATERIAL_NAME="__DEFAULT";var qr=new st,Yr=new De,Le=new st,Yi=class extends En{constructor(){super(),this.isCamera=!0,this.type="Camera",this.matrixWorldInverse=new _e,this.projectionMatrix=new _e,this.projectionMatrixInverse=new _e,this.coordinateSystem=li,this._reversedDepth=!1}get reversedDepth(){return this._reversedDepth}copy(t,e){return super.copy(t,e),this.matrixWorldInverse.copy(t.matrixWorldInverse),this.projectionMatrix.copy(t.projectionMatrix),this.projectionMatrixInverse.copy(t.projectionMatrixInverse),this.coordinateSystem=t.coordinateSystem,this}getWorldDirection(t){return super.getWorldDirection(t).negate()}updateMatrixWorld(t){super.updateMatrixWorld(t),this.matrixWorld.decompose(qr,Yr,Le),Le.x===1&&Le.y===1&&Le.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose(qr,Yr,Le.set(1,1,1)).invert()}updateWorldMatrix(t,e,i=!1){super.updateWorldMatrix(t,e,i),this.matrixWorld.decompose(qr,Yr,Le),Le.x===1&&Le.y===1&&Le.z===1?this.matrixWorldInverse.copy(this.matrixWorld).invert():this.matrixWorldInverse.compose(qr,Yr,Le.set(1,1,1)).invert()}clone(){return new this.constructor().copy(this)}},ln=new st,Ec=new oe,Ac=new oe,Zi=class extends Yi{constructor(t=50,e=1,i=.1,r=2e3){super(),this.isPerspectiveCamera=!0,this.type="PerspectiveCamera",this.fov=t,this.zoom=1,this.near=i,this.far=r,this.focus=10,this.aspect=e,this.view=null,this.filmGauge=35,this.filmOffset=0,this.updateProjectionMatrix()}copy(t,e){return super.copy(t,e),this.fov=t.fov,this.zoom=t.zoom,this.near=t.near,this.far=t.far,this.focus=t.focus,this.aspect=t.aspect,this.view=t.view===null?null:Object.assign({},t.view),this.filmGauge=t.filmGauge,this.filmOffset=t.filmOffset,this}setFocalLength(t){let e=.5*this.getFilmHeight()/t;this.fov=Wi*2*Math.atan(e),this.updateProjectionMatrix()}getFocalLength(){let t=Math.tan(ki*.5*this.fov);return .5*this.getFilmHeight()/t}getEffectiveFOV(){return Wi*2*Math.atan(Math.tan(ki*.5*this.fov)/this.zoom)}getFilmWidth(){return this.filmGauge*Math.min(this.aspect,1)}getFilmHeight(){return this.filmGauge/Math.max(this.aspect,1)}getViewBounds(t,e,i){ln.set(-1,-1,.5).applyMatrix4(this.projectionMatrixInverse),e.set(ln.x,ln.y).multiplyScalar(-t/ln.z),ln.set(1,1,.5).applyMatrix4(this.projectionMatrixInverse),i.set(ln.x,ln.y).multiplyScalar(-t/ln.z)}getViewSize(t,e){return this.getViewBounds(t,Ec,Ac),e.subVectors(Ac,Ec)}setViewOffset(t,e,i,r,s,a){this.aspect=t/e,this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=e,this.view.offsetX=i,this.view.offsetY=r,this.view.width=s,this.view.height=a,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=this.near,e=t*Math.tan(ki*.5*this.fov)/this.zoom,i=2*e,r=this.aspect*i,s=-.5*r,a=this.view;if(this.view!==null&&this.view.enabled){let h=a.fullWidth,l=a.fullHeight;s+=a.offsetX*r/h,e-=a.offsetY*i/l,r*=a.width/h,i*=a.height/l}let o=this.filmOffset;o!==0&&(s+=t*o/this.getFilmWidth()),this.projectionMatrix.makePerspective(s,s+r,e,e-i,t,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let e=super.toJSON(t);return e.object.fov=this.fov,e.object.zoom=this.zoom,e.object.near=this.near,e.object.far=this.far,e.object.focus=this.focus,e.object.aspect=this.aspect,this.view!==null&&(e.object.view=Object.assign({},this.view)),e.object.filmGauge=this.filmGauge,e.object.filmOffset=this.filmOffset,e}};var Ji=class extends Yi{constructor(t=-1,e=1,i=1,r=-1,s=.1,a=2e3){super(),this.isOrthographicCamera=!0,this.type="OrthographicCamera",this.zoom=1,this.view=null,this.left=t,this.right=e,this.top=i,this.bottom=r,this.near=s,this.far=a,this.updateProjectionMatrix()}copy(t,e){return super.copy(t,e),this.left=t.left,this.right=t.right,this.top=t.top,this.bottom=t.bottom,this.near=t.near,this.far=t.far,this.zoom=t.zoom,this.view=t.view===null?null:Object.assign({},t.view),this}setViewOffset(t,e,i,r,s,a){this.view===null&&(this.view={enabled:!0,fullWidth:1,fullHeight:1,offsetX:0,offsetY:0,width:1,height:1}),this.view.enabled=!0,this.view.fullWidth=t,this.view.fullHeight=e,this.view.offsetX=i,this.view.offsetY=r,this.view.width=s,this.view.height=a,this.updateProjectionMatrix()}clearViewOffset(){this.view!==null&&(this.view.enabled=!1),this.updateProjectionMatrix()}updateProjectionMatrix(){let t=(this.right-this.left)/(2*this.zoom),e=(this.top-this.bottom)/(2*this.zoom),i=(this.right+this.left)/2,r=(this.top+this.bottom)/2,s=i-t,a=i+t,o=r+e,h=r-e;if(this.view!==null&&this.view.enabled){let l=(this.right-this.left)/this.view.fullWidth/this.zoom,c=(this.top-this.bottom)/this.view.fullHeight/this.zoom;s+=l*this.view.offsetX,a=s+l*this.view.width,o-=c*this.view.offsetY,h=o-c*this.view.height}this.projectionMatrix.makeOrthographic(s,a,o,h,this.near,this.far,this.coordinateSystem,this.reversedDepth),this.projectionMatrixInverse.copy(this.projectionMatrix).invert()}toJSON(t){let e=super.toJSON(t);return e.object.zoom=this.zoom,e.object.left=this.left,e.object.right=this.right,e.object.top=this.top,e.object.bottom=this.bottom,e.object.near=this.near,e.object.far=this.far,this.view!==null&&(e.object.view=Object.assign({},this.view)),e}};var Do="\\[\\]\\.:\\/",ag=new RegExp("["+Do+"]","g"),Uo="[^"+Do+"]",og="[^"+Do.replace("\\.","")+"]",lg=/((?:WC+[\/:])*)/.source.replace("WC",Uo),cg=/(WCOD+)?/.source.replace("WCOD",og),hg=/(?:\.(WC+)(?:\[(.+)\])?)?/.source.replace("WC",Uo),ug=/\.(WC+)(?:\[(.+)\])?/.source.replace("WC",Uo),fg=new RegExp("^"+lg+cg+hg+ug+"$"),dg=["material","materials","bones","map"],Mo=class{constructor(t,e,i){let r=i||yt.parseTrackName(e);this._targetGroup=t,this._bindings=t.subscribe_(e,r)}getValue(t,e){this.bind();let i=this._targetGroup.nCachedObjects_,r=this._bindings[i];r!==void 0&&r.getValue(t,e)}setValue(t,e){let i=this._bindings;for(let r=this._targetGroup.nCachedObjects_,s=i.length;r!==s;++r)i[r].setValue(t,e)}bind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,i=t.length;e!==i;++e)t[e].bind()}unbind(){let t=this._bindings;for(let e=this._targetGroup.nCachedObjects_,i=t.length;e!==i;++e)t[e].unbind()}},yt=class n{constructor(t,e,i){this.path=e,this.parsedPath=i||n.parseTrackName(e),this.node=n.findNode(t,this.parsedPath.nodeName),this.rootNode=t,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}static create(t,e,i){return t&&t.isAnimationObjectGroup?new n.Composite(t,e,i):new n(t,e,i)}static sanitizeNodeName(t){return t.replace(/\s/g,"_").replace(ag,"")}static parseTrackName(t){let e=fg.exec(t);if(e===null)throw new Error("THREE.PropertyBinding: Cannot parse trackName: "+t);let i={nodeName:e[2],objectName:e[3],objectIndex:e[4],propertyName:e[5],propertyIndex:e[6]},r=i.nodeName&&i.nodeName.lastIndexOf(".");if(r!==void 0&&r!==-1){let s=i.nodeName.substring(r+1);dg.indexOf(s)!==-1&&(i.nodeName=i.nodeName.substring(0,r),i.objectName=s)}if(i.propertyName===null||i.propertyName.length===0)throw new Error("THREE.PropertyBinding: can not parse propertyName from trackName: "+t);return i}static findNode(t,e){if(e===void 0||e===""||e==="."||e===-1||e===t.name||e===t.uuid)return t;if(t.skeleton){let i=t.skeleton.getBoneByName(e);if(i!==void 0)return i}if(t.children){let i=function(s){for(let a=0;a<s.length;a++){let o=s[a];if(o.name===e||o.uuid===e)return o;let h=i(o.children);if(h)return h}return null},r=i(t.children);if(r)return r}return null}_getValue_unavailable(){}_setValue_unavailable(){}_getValue_direct(t,e){t[e]=this.targetObject[this.propertyName]}_getValue_array(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)t[e++]=i[r]}_getValue_arrayElement(t,e){t[e]=this.resolvedProperty[this.propertyIndex]}_getValue_toArray(t,e){this.resolvedProperty.toArray(t,e)}_setValue_direct(t,e){this.targetObject[this.propertyName]=t[e]}_setValue_direct_setNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.needsUpdate=!0}_setValue_direct_setMatrixWorldNeedsUpdate(t,e){this.targetObject[this.propertyName]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_array(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[e++]}_setValue_array_setNeedsUpdate(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[e++];this.targetObject.needsUpdate=!0}_setValue_array_setMatrixWorldNeedsUpdate(t,e){let i=this.resolvedProperty;for(let r=0,s=i.length;r!==s;++r)i[r]=t[e++];this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_arrayElement(t,e){this.resolvedProperty[this.propertyIndex]=t[e]}_setValue_arrayElement_setNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.needsUpdate=!0}_setValue_arrayElement_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty[this.propertyIndex]=t[e],this.targetObject.matrixWorldNeedsUpdate=!0}_setValue_fromArray(t,e){this.resolvedProperty.fromArray(t,e)}_setValue_fromArray_setNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.needsUpdate=!0}_setValue_fromArray_setMatrixWorldNeedsUpdate(t,e){this.resolvedProperty.fromArray(t,e),this.targetObject.matrixWorldNeedsUpdate=!0}_getValue_unbound(t,e){this.bind(),this.getValue(t,e)}_setValue_unbound(t,e){this.bind(),this.setValue(t,e)}bind(){let t=this.node,e=this.parsedPath,i=e.objectName,r=e.propertyName,s=e.propertyIndex;if(t||(t=n.findNode(this.rootNode,e.nodeName),this.node=t),this.getValue=this._getValue_unavailable,this.setValue=this._setValue_unavailable,!t){Ht("PropertyBinding: No target node found for track: "+this.path+".");return}if(i){let l=e.objectIndex;switch(i){case"materials":if(!t.material){Ut("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.materials){Ut("PropertyBinding: Can not bind to material.materials as node.material does not have a materials array.",this);return}t=t.material.materials;break;case"bones":if(!t.skeleton){Ut("PropertyBinding: Can not bind to bones as node does not have a skeleton.",this);return}t=t.skeleton.bones;for(let c=0;c<t.length;c++)if(t[c].name===l){l=c;break}break;case"map":if("map"in t){t=t.map;break}if(!t.material){Ut("PropertyBinding: Can not bind to material as node does not have a material.",this);return}if(!t.material.map){Ut("PropertyBinding: Can not bind to material.map as node.material does not have a map.",this);return}t=t.material.map;break;default:if(t[i]===void 0){Ut("PropertyBinding: Can not bind to objectName of node undefined.",this);return}t=t[i]}if(l!==void 0){if(t[l]===void 0){Ut("PropertyBinding: Trying to bind to objectIndex of objectName, but is undefined.",this,t);return}t=t[l]}}let a=t[r];if(a===void 0){let l=e.nodeName;Ut("PropertyBinding: Trying to update property for track: "+l+"."+r+" but it wasn't found.",t);return}let o=this.Versioning.None;this.targetObject=t,t.isMaterial===!0?o=this.Versioning.NeedsUpdate:t.isObject3D===!0&&(o=this.Versioning.MatrixWorldNeedsUpdate);let h=this.BindingType.Direct;if(s!==void 0){if(r==="morphTargetInfluences"){if(!t.geometry){Ut("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.",this);return}if(!t.geometry.morphAttributes){Ut("PropertyBinding: Can not bind to morphTargetInfluences because node does not have a geometry.morphAttributes.",this);return}t.morphTargetDictionary[s]!==void 0&&(s=t.morphTargetDictionary[s])}h=this.BindingType.ArrayElement,this.resolvedProperty=a,this.propertyIndex=s}else a.fromArray!==void 0&&a.toArray!==void 0?(h=this.BindingType.HasFromToArray,this.resolvedProperty=a):Array.isArray(a)?(h=this.BindingType.EntireArray,this.resolvedProperty=a):this.propertyName=r;this.getValue=this.GetterByBindingType[h],this.setValue=this.SetterByBindingTypeAndVersioning[h][o]}unbind(){this.node=null,this.getValue=this._getValue_unbound,this.setValue=this._setValue_unbound}};yt.Composite=Mo;yt.prototype.BindingType={Direct:0,EntireArray:1,ArrayElement:2,HasFromToArray:3};yt.prototype.Versioning={None:0,NeedsUpdate:1,MatrixWorldNeedsUpdate:2};yt.prototype.GetterByBindingType=[yt.prototype._getValue_direct,yt.prototype._getValue_array,yt.prototype._getValue_arrayElement,yt.prototype._getValue_toArray];yt.prototype.SetterByBindingTypeAndVersioning=[[yt.prototype._setValue_direct,yt.prototype._setValue_direct_setNeedsUpdate,yt.prototype._setValue_direct_setMatrixWorldNeedsUpdate],[yt.prototype._setValue_array,yt.prototype._setValue_array_setNeedsUpdate,yt.prototype._setValue_array_setMatrixWorldNeedsUpdate],[yt.prototype._setValue_arrayElement,yt.prototype._setValue_arrayElement_setNeedsUpdate,yt.prototype._setValue_arrayElement_setMatrixWorldNeedsUpdate],[yt.prototype._setValue_fromArray,yt.prototype._setValue_fromArray_setNeedsUpdate,yt.prototype._setValue_fromArray_setMatrixWorldNeedsUpdate]];var xE=new Float32Array(1);var bo=class{static{this.prototype.isMatrix2=!0}constructor(t,e,i,r){this.elements=[1,0,0,1],t!==void 0&&this.set(t,e,i,r)}identity(){return this.set(1,0,0,1),this}fromArray(t,e=0){for(let i=0;i<4;i++)this.elements[i]=t[i+e];return this}set(t,e,i,r){let s=this.elements;return s[0]=t,s[2]=e,s[1]=i,s[3]=r,this}};typeof __THREE_DEVTOOLS__<"u"&&__THREE_DEVTOOLS__.dispatchEvent(new CustomEvent("register",{detail:{revision:"187"}}));typeof window<"u"&&(window.__THREE__?Ht("WARNING: Multiple instances of Three.js being imported."):window.__THREE__="187");var pg=`#ifdef USE_ALPHAHASH
	if ( diffuseColor.a < getAlphaHashThreshold( vPosition ) ) discard;
#endif`,mg=`#ifdef USE_ALPHAHASH
	const float ALPHA_HASH_SCALE = 0.05;
	float hash2D( vec2 value ) {
		return fract( 1.0e4 * sin( 17.0 * value.x + 0.1 * value.y ) * ( 0.1 + abs( sin( 13.0 * value.y + value.x ) ) ) );
	}
	float hash3D( vec3 value ) {
		return hash2D( vec2( hash2D( value.xy ), value.z ) );
	}
	float getAlphaHashThreshold( vec3 position ) {
		float maxDeriv = max(
			length( dFdx( position.xyz ) ),
			length( dFdy( position.xyz ) )
		);
		float pixScale = 1.0 / ( ALPHA_HASH_SCALE * maxDeriv );
		vec2 pixScales = vec2(
			exp2( floor( log2( pixScale ) ) ),
			exp2( ceil( log2( pixScale ) ) )
		);
		vec2 alpha = vec2(
			hash3D( floor( pixScales.x * position.xyz ) ),
			hash3D( floor( pixScales.y * position.xyz ) )
		);
		float lerpFactor = fract( log2( pixScale ) );
		float x = ( 1.0 - lerpFactor ) * alpha.x + lerpFactor * alpha.y;
		float a = min( lerpFactor, 1.0 - lerpFactor );
		vec3 cases = vec3(
			x * x / ( 2.0 * a * ( 1.0 - a ) ),
			( x - 0.5 * a ) / ( 1.0 - a ),
			1.0 - ( ( 1.0 - x ) * ( 1.0 - x ) / ( 2.0 * a * ( 1.0 - a ) ) )
		);
		float threshold = ( x < ( 1.0 - a ) )
			? ( ( x < a ) ? cases.x : cases.y )
			: cases.z;
		return clamp( threshold , 1.0e-6, 1.0 );
	}
#endif`,gg=`#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, vAlphaMapUv ).g;
#endif`,_g=`#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,xg=`#ifdef USE_ALPHATEST
	#ifdef ALPHA_TO_COVERAGE
	diffuseColor.a = smoothstep( alphaTest, alphaTest + fwidth( diffuseColor.a ), diffuseColor.a );
	if ( diffuseColor.a == 0.0 ) discard;
	#else
	if ( diffuseColor.a < alphaTest ) discard;
	#endif
#endif`,vg=`#ifdef USE_ALPHATEST
	uniform float alphaTest;
#endif`,yg=`#ifdef USE_AOMAP
	float ambientOcclusion = ( texture2D( aoMap, vAoMapUv ).r - 1.0 ) * aoMapIntensity + 1.0;
	reflectedLight.indirectDiffuse *= ambientOcclusion;
	#if defined( USE_CLEARCOAT ) 
		clearcoatSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_SHEEN ) 
		sheenSpecularIndirect *= ambientOcclusion;
	#endif
	#if defined( USE_ENVMAP ) && defined( STANDARD )
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		reflectedLight.indirectSpecular *= computeSpecularOcclusion( dotNV, ambientOcclusion, material.roughness );
	#endif
#endif`,Sg=`#ifdef USE_AOMAP
	uniform sampler2D aoMap;
	uniform float aoMapIntensity;
#endif`,Mg=`#ifdef USE_BATCHING
	#if ! defined( GL_ANGLE_multi_draw )
	#define gl_DrawID _gl_DrawID
	uniform int _gl_DrawID;
	#endif
	uniform highp sampler2D batchingTexture;
	uniform highp usampler2D batchingIdTexture;
	mat4 getBatchingMatrix( const in float i ) {
		int size = textureSize( batchingTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( batchingTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( batchingTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( batchingTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( batchingTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
	float getIndirectIndex( const in int i ) {
		int size = textureSize( batchingIdTexture, 0 ).x;
		int x = i % size;
		int y = i / size;
		return float( texelFetch( batchingIdTexture, ivec2( x, y ), 0 ).r );
	}
#endif
#ifdef USE_BATCHING_COLOR
	uniform sampler2D batchingColorTexture;
	vec4 getBatchingColor( const in float i ) {
		int size = textureSize( batchingColorTexture, 0 ).x;
		int j = int( i );
		int x = j % size;
		int y = j / size;
		return texelFetch( batchingColorTexture, ivec2( x, y ), 0 );
	}
#endif`,bg=`#ifdef USE_BATCHING
	mat4 batchingMatrix = getBatchingMatrix( getIndirectIndex( gl_DrawID ) );
#endif`,wg=`vec3 transformed = vec3( position );
#ifdef USE_ALPHAHASH
	vPosition = vec3( position );
#endif`,Eg=`vec3 objectNormal = vec3( normal );
#ifdef USE_TANGENT
	vec3 objectTangent = vec3( tangent.xyz );
#endif`,Ag=`float G_BlinnPhong_Implicit( ) {
	return 0.25;
}
float D_BlinnPhong( const in float shininess, const in float dotNH ) {
	return RECIPROCAL_PI * ( shininess * 0.5 + 1.0 ) * pow( dotNH, shininess );
}
vec3 BRDF_BlinnPhong( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 specularColor, const in float shininess ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( specularColor, 1.0, dotVH );
	float G = G_BlinnPhong_Implicit( );
	float D = D_BlinnPhong( shininess, dotNH );
	return F * ( G * D );
} // validated`,Tg=`#ifdef USE_IRIDESCENCE
	const mat3 XYZ_TO_REC709 = mat3(
		 3.2404542, -0.9692660,  0.0556434,
		-1.5371385,  1.8760108, -0.2040259,
		-0.4985314,  0.0415560,  1.0572252
	);
	vec3 Fresnel0ToIor( vec3 fresnel0 ) {
		vec3 sqrtF0 = sqrt( fresnel0 );
		return ( vec3( 1.0 ) + sqrtF0 ) / ( vec3( 1.0 ) - sqrtF0 );
	}
	vec3 IorToFresnel0( vec3 transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - vec3( incidentIor ) ) / ( transmittedIor + vec3( incidentIor ) ) );
	}
	float IorToFresnel0( float transmittedIor, float incidentIor ) {
		return pow2( ( transmittedIor - incidentIor ) / ( transmittedIor + incidentIor ));
	}
	vec3 evalSensitivity( float OPD, vec3 shift ) {
		float phase = 2.0 * PI * OPD * 1.0e-9;
		vec3 val = vec3( 5.4856e-13, 4.4201e-13, 5.2481e-13 );
		vec3 pos = vec3( 1.6810e+06, 1.7953e+06, 2.2084e+06 );
		vec3 var = vec3( 4.3278e+09, 9.3046e+09, 6.6121e+09 );
		vec3 xyz = val * sqrt( 2.0 * PI * var ) * cos( pos * phase + shift ) * exp( - pow2( phase ) * var );
		xyz.x += 9.7470e-14 * sqrt( 2.0 * PI * 4.5282e+09 ) * cos( 2.2399e+06 * phase + shift[ 0 ] ) * exp( - 4.5282e+09 * pow2( phase ) );
		xyz /= 1.0685e-7;
		vec3 rgb = XYZ_TO_REC709 * xyz;
		return rgb;
	}
	vec3 evalIridescence( float outsideIOR, float eta2, float cosTheta1, float thinFilmThickness, vec3 baseF0 ) {
		vec3 I;
		float iridescenceIOR = mix( outsideIOR, eta2, smoothstep( 0.0, 0.03, thinFilmThickness ) );
		float sinTheta2Sq = pow2( outsideIOR / iridescenceIOR ) * ( 1.0 - pow2( cosTheta1 ) );
		float cosTheta2Sq = 1.0 - sinTheta2Sq;
		if ( cosTheta2Sq < 0.0 ) {
			return vec3( 1.0 );
		}
		float cosTheta2 = sqrt( cosTheta2Sq );
		float R0 = IorToFresnel0( iridescenceIOR, outsideIOR );
		float R12 = F_Schlick( R0, 1.0, cosTheta1 );
		float T121 = 1.0 - R12;
		float phi12 = 0.0;
		if ( iridescenceIOR < outsideIOR ) phi12 = PI;
		float phi21 = PI - phi12;
		vec3 baseIOR = Fresnel0ToIor( clamp( baseF0, 0.0, 0.9999 ) );		vec3 R1 = IorToFresnel0( baseIOR, iridescenceIOR );
		vec3 R23 = F_Schlick( R1, 1.0, cosTheta2 );
		vec3 phi23 = vec3( 0.0 );
		if ( baseIOR[ 0 ] < iridescenceIOR ) phi23[ 0 ] = PI;
		if ( baseIOR[ 1 ] < iridescenceIOR ) phi23[ 1 ] = PI;
		if ( baseIOR[ 2 ] < iridescenceIOR ) phi23[ 2 ] = PI;
		float OPD = 2.0 * iridescenceIOR * thinFilmThickness * cosTheta2;
		vec3 phi = vec3( phi21 ) + phi23;
		vec3 R123 = clamp( R12 * R23, 1e-5, 0.9999 );
		vec3 r123 = sqrt( R123 );
		vec3 Rs = pow2( T121 ) * R23 / ( vec3( 1.0 ) - R123 );
		vec3 C0 = R12 + Rs;
		I = C0;
		vec3 Cm = Rs - T121;
		for ( int m = 1; m <= 2; ++ m ) {
			Cm *= r123;
			vec3 Sm = 2.0 * evalSensitivity( float( m ) * OPD, float( m ) * phi );
			I += Cm * Sm;
		}
		return max( I, vec3( 0.0 ) );
	}
#endif`,Rg=`#ifdef USE_BUMPMAP
	uniform sampler2D bumpMap;
	uniform float bumpScale;
	vec2 dHdxy_fwd() {
		vec2 dSTdx = dFdx( vBumpMapUv );
		vec2 dSTdy = dFdy( vBumpMapUv );
		float Hll = bumpScale * texture2D( bumpMap, vBumpMapUv ).x;
		float dBx = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdx ).x - Hll;
		float dBy = bumpScale * texture2D( bumpMap, vBumpMapUv + dSTdy ).x - Hll;
		return vec2( dBx, dBy );
	}
	vec3 perturbNormalArb( vec3 surf_pos, vec3 surf_norm, vec2 dHdxy, float faceDirection ) {
		vec3 vSigmaX = normalize( dFdx( surf_pos.xyz ) );
		vec3 vSigmaY = normalize( dFdy( surf_pos.xyz ) );
		vec3 vN = surf_norm;
		vec3 R1 = cross( vSigmaY, vN );
		vec3 R2 = cross( vN, vSigmaX );
		float fDet = dot( vSigmaX, R1 ) * faceDirection;
		vec3 vGrad = sign( fDet ) * ( dHdxy.x * R1 + dHdxy.y * R2 );
		return normalize( abs( fDet ) * surf_norm - vGrad );
	}
#endif`,Cg=`#if NUM_CLIPPING_PLANES > 0
	vec4 plane;
	#ifdef ALPHA_TO_COVERAGE
		float distanceToPlane, distanceGradient;
		float clipOpacity = 1.0;
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
			distanceGradient = fwidth( distanceToPlane ) / 2.0;
			clipOpacity *= smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			if ( clipOpacity == 0.0 ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			float unionClipOpacity = 1.0;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				distanceToPlane = - dot( vClipPosition, plane.xyz ) + plane.w;
				distanceGradient = fwidth( distanceToPlane ) / 2.0;
				unionClipOpacity *= 1.0 - smoothstep( - distanceGradient, distanceGradient, distanceToPlane );
			}
			#pragma unroll_loop_end
			clipOpacity *= 1.0 - unionClipOpacity;
		#endif
		diffuseColor.a *= clipOpacity;
		if ( diffuseColor.a == 0.0 ) discard;
	#else
		#pragma unroll_loop_start
		for ( int i = 0; i < UNION_CLIPPING_PLANES; i ++ ) {
			plane = clippingPlanes[ i ];
			if ( dot( vClipPosition, plane.xyz ) > plane.w ) discard;
		}
		#pragma unroll_loop_end
		#if UNION_CLIPPING_PLANES < NUM_CLIPPING_PLANES
			bool clipped = true;
			#pragma unroll_loop_start
			for ( int i = UNION_CLIPPING_PLANES; i < NUM_CLIPPING_PLANES; i ++ ) {
				plane = clippingPlanes[ i ];
				clipped = ( dot( vClipPosition, plane.xyz ) > plane.w ) && clipped;
			}
			#pragma unroll_loop_end
			if ( clipped ) discard;
		#endif
	#endif
#endif`,Ig=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
	uniform vec4 clippingPlanes[ NUM_CLIPPING_PLANES ];
#endif`,Pg=`#if NUM_CLIPPING_PLANES > 0
	varying vec3 vClipPosition;
#endif`,Ng=`#if NUM_CLIPPING_PLANES > 0
	vClipPosition = - mvPosition.xyz;
#endif`,Lg=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	diffuseColor *= vColor;
#endif`,Dg=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA )
	varying vec4 vColor;
#endif`,Ug=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	varying vec4 vColor;
#endif`,Fg=`#if defined( USE_COLOR ) || defined( USE_COLOR_ALPHA ) || defined( USE_INSTANCING_COLOR ) || defined( USE_BATCHING_COLOR )
	vColor = vec4( 1.0 );
#endif
#ifdef USE_COLOR_ALPHA
	vColor *= color;
#elif defined( USE_COLOR )
	vColor.rgb *= color;
#endif
#ifdef USE_INSTANCING_COLOR
	vColor.rgb *= instanceColor.rgb;
#endif
#ifdef USE_BATCHING_COLOR
	vColor *= getBatchingColor( getIndirectIndex( gl_DrawID ) );
#endif`,Og=`#define PI 3.141592653589793
#define PI2 6.283185307179586
#define PI_HALF 1.5707963267948966
#define RECIPROCAL_PI 0.3183098861837907
#define RECIPROCAL_PI2 0.15915494309189535
#define EPSILON 1e-6
#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
#define whiteComplement( a ) ( 1.0 - saturate( a ) )
float pow2( const in float x ) { return x*x; }
vec3 pow2( const in vec3 x ) { return x*x; }
float pow3( const in float x ) { return x*x*x; }
float pow4( const in float x ) { float x2 = x*x; return x2*x2; }
float max3( const in vec3 v ) { return max( max( v.x, v.y ), v.z ); }
float average( const in vec3 v ) { return dot( v, vec3( 0.3333333 ) ); }
highp float rand( const in vec2 uv ) {
	const highp float a = 12.9898, b = 78.233, c = 43758.5453;
	highp float dt = dot( uv.xy, vec2( a,b ) ), sn = mod( dt, PI );
	return fract( sin( sn ) * c );
}
#ifdef HIGH_PRECISION
	float precisionSafeLength( vec3 v ) { return length( v ); }
#else
	float precisionSafeLength( vec3 v ) {
		float maxComponent = max3( abs( v ) );
		return length( v / maxComponent ) * maxComponent;
	}
#endif
struct IncidentLight {
	vec3 color;
	vec3 direction;
	bool visible;
};
struct ReflectedLight {
	vec3 directDiffuse;
	vec3 directSpecular;
	vec3 indirectDiffuse;
	vec3 indirectSpecular;
};
#ifdef USE_ALPHAHASH
	varying vec3 vPosition;
#endif
vec3 transformDirection( in vec3 dir, in mat4 matrix ) {
	return normalize( ( matrix * vec4( dir, 0.0 ) ).xyz );
}
#define inverseTransformDirection transformDirectionByInverseViewMatrix
vec3 transformNormalByInverseViewMatrix( in vec3 normal, in mat4 viewMatrix ) {
	return normalize( ( vec4( normal, 0.0 ) * viewMatrix ).xyz );
}
vec3 transformDirectionByInverseViewMatrix( in vec3 dir, in mat4 viewMatrix ) {
	return normalize( ( vec4( dir, 0.0 ) * viewMatrix ).xyz );
}
bool isPerspectiveMatrix( mat4 m ) {
	return m[ 2 ][ 3 ] == - 1.0;
}
vec2 equirectUv( in vec3 dir ) {
	float u = atan( dir.z, dir.x ) * RECIPROCAL_PI2 + 0.5;
	float v = asin( clamp( dir.y, - 1.0, 1.0 ) ) * RECIPROCAL_PI + 0.5;
	return vec2( u, v );
}
vec3 BRDF_Lambert( const in vec3 diffuseColor ) {
	return RECIPROCAL_PI * diffuseColor;
}
vec3 F_Schlick( const in vec3 f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
}
float F_Schlick( const in float f0, const in float f90, const in float dotVH ) {
	float fresnel = exp2( ( - 5.55473 * dotVH - 6.98316 ) * dotVH );
	return f0 * ( 1.0 - fresnel ) + ( f90 * fresnel );
} // validated`,Bg=`vec3 transformedNormal = objectNormal;
#ifdef USE_TANGENT
	vec3 transformedTangent = objectTangent;
#endif
#ifdef USE_BATCHING
	mat3 bm = mat3( batchingMatrix );
	transformedNormal /= vec3( dot( bm[ 0 ], bm[ 0 ] ), dot( bm[ 1 ], bm[ 1 ] ), dot( bm[ 2 ], bm[ 2 ] ) );
	transformedNormal = bm * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = bm * transformedTangent;
	#endif
#endif
#ifdef USE_INSTANCING
	mat3 im = mat3( instanceMatrix );
	transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );
	transformedNormal = im * transformedNormal;
	#ifdef USE_TANGENT
		transformedTangent = im * transformedTangent;
	#endif
#endif
transformedNormal = normalMatrix * transformedNormal;
#ifdef FLIP_SIDED
	transformedNormal = - transformedNormal;
#endif
#ifdef USE_TANGENT
	transformedTangent = ( modelViewMatrix * vec4( transformedTangent, 0.0 ) ).xyz;
#endif`,zg=`#ifdef USE_DISPLACEMENTMAP
	uniform sampler2D displacementMap;
	uniform float displacementScale;
	uniform float displacementBias;
#endif`,kg=`#ifdef USE_DISPLACEMENTMAP
	transformed += normalize( objectNormal ) * ( texture2D( displacementMap, vDisplacementMapUv ).x * displacementScale + displacementBias );
#endif`,Gg=`#ifdef USE_EMISSIVEMAP
	vec4 emissiveColor = texture2D( emissiveMap, vEmissiveMapUv );
	#ifdef DECODE_VIDEO_TEXTURE_EMISSIVE
		emissiveColor = sRGBTransferEOTF( emissiveColor );
	#endif
	totalEmissiveRadiance *= emissiveColor.rgb;
#endif`,Vg=`#ifdef USE_EMISSIVEMAP
	uniform sampler2D emissiveMap;
#endif`,Hg="gl_FragColor = linearToOutputTexel( gl_FragColor );",Wg=`vec4 LinearTransferOETF( in vec4 value ) {
	return value;
}
vec4 sRGBTransferEOTF( in vec4 value ) {
	return vec4( mix( pow( value.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), value.rgb * 0.0773993808, vec3( lessThanEqual( value.rgb, vec3( 0.04045 ) ) ) ), value.a );
}
vec4 sRGBTransferOETF( in vec4 value ) {
	return vec4( mix( pow( value.rgb, vec3( 0.41666 ) ) * 1.055 - vec3( 0.055 ), value.rgb * 12.92, vec3( lessThanEqual( value.rgb, vec3( 0.0031308 ) ) ) ), value.a );
}`,Xg=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vec3 cameraToFrag;
		if ( isOrthographic ) {
			cameraToFrag = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToFrag = normalize( vWorldPosition - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vec3 reflectVec = reflect( cameraToFrag, worldNormal );
		#else
			vec3 reflectVec = refract( cameraToFrag, worldNormal, refractionRatio );
		#endif
	#else
		vec3 reflectVec = vReflect;
	#endif
	#ifdef ENVMAP_TYPE_CUBE
		vec4 envColor = textureCube( envMap, envMapRotation * reflectVec );
		#ifdef ENVMAP_BLENDING_MULTIPLY
			outgoingLight = mix( outgoingLight, outgoingLight * envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_MIX )
			outgoingLight = mix( outgoingLight, envColor.xyz, specularStrength * reflectivity );
		#elif defined( ENVMAP_BLENDING_ADD )
			outgoingLight += envColor.xyz * specularStrength * reflectivity;
		#endif
	#endif
#endif`,qg=`#ifdef USE_ENVMAP
	uniform float envMapIntensity;
	uniform mat3 envMapRotation;
	uniform samplerCube envMap;
	#ifdef ENVMAP_TYPE_PMREM
		float roughnessToMip( const in float roughness ) {
			float r = clamp( roughness, 0.0, 1.0 );
			return ENVMAP_MAX_LOD * r * ( 2.0 - r );
		}
	#endif
#endif`,Yg=`#ifdef USE_ENVMAP
	uniform float reflectivity;
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		varying vec3 vWorldPosition;
		uniform float refractionRatio;
	#else
		varying vec3 vReflect;
	#endif
#endif`,Zg=`#ifdef USE_ENVMAP
	#if defined( USE_BUMPMAP ) || defined( USE_NORMALMAP ) || defined( PHONG ) || defined( LAMBERT )
		#define ENV_WORLDPOS
	#endif
	#ifdef ENV_WORLDPOS
		
		varying vec3 vWorldPosition;
	#else
		varying vec3 vReflect;
		uniform float refractionRatio;
	#endif
#endif`,Jg=`#ifdef USE_ENVMAP
	#ifdef ENV_WORLDPOS
		vWorldPosition = worldPosition.xyz;
	#else
		vec3 cameraToVertex;
		if ( isOrthographic ) {
			cameraToVertex = normalize( vec3( - viewMatrix[ 0 ][ 2 ], - viewMatrix[ 1 ][ 2 ], - viewMatrix[ 2 ][ 2 ] ) );
		} else {
			cameraToVertex = normalize( worldPosition.xyz - cameraPosition );
		}
		vec3 worldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
		#ifdef ENVMAP_MODE_REFLECTION
			vReflect = reflect( cameraToVertex, worldNormal );
		#else
			vReflect = refract( cameraToVertex, worldNormal, refractionRatio );
		#endif
	#endif
#endif`,$g=`#ifdef USE_FOG
	vFogDepth = - mvPosition.z;
#endif`,Kg=`#ifdef USE_FOG
	varying float vFogDepth;
#endif`,Qg=`#ifdef USE_FOG
	#ifdef FOG_EXP2
		float fogFactor = 1.0 - exp( - fogDensity * fogDensity * vFogDepth * vFogDepth );
	#else
		float fogFactor = smoothstep( fogNear, fogFar, vFogDepth );
	#endif
	gl_FragColor.rgb = mix( gl_FragColor.rgb, fogColor, fogFactor );
#endif`,jg=`#ifdef USE_FOG
	uniform vec3 fogColor;
	varying float vFogDepth;
	#ifdef FOG_EXP2
		uniform float fogDensity;
	#else
		uniform float fogNear;
		uniform float fogFar;
	#endif
#endif`,t0=`#ifdef USE_GRADIENTMAP
	uniform sampler2D gradientMap;
#endif
vec3 getGradientIrradiance( vec3 normal, vec3 lightDirection ) {
	float dotNL = dot( normal, lightDirection );
	vec2 coord = vec2( dotNL * 0.5 + 0.5, 0.0 );
	#ifdef USE_GRADIENTMAP
		return vec3( texture2D( gradientMap, coord ).r );
	#else
		vec2 fw = fwidth( coord ) * 0.5;
		return mix( vec3( 0.7 ), vec3( 1.0 ), smoothstep( 0.7 - fw.x, 0.7 + fw.x, coord.x ) );
	#endif
}`,e0=`#ifdef USE_LIGHTMAP
	uniform sampler2D lightMap;
	uniform float lightMapIntensity;
#endif`,n0=`LambertMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularStrength = specularStrength;`,i0=`varying vec3 vViewPosition;
struct LambertMaterial {
	vec3 diffuseColor;
	float specularStrength;
};
void RE_Direct_Lambert( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Lambert( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in LambertMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Lambert
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Lambert`,r0=`uniform bool receiveShadow;
uniform vec3 ambientLightColor;
#if defined( USE_LIGHT_PROBES )
	uniform vec3 lightProbe[ 9 ];
#endif
vec3 shGetIrradianceAt( in vec3 normal, in vec3 shCoefficients[ 9 ] ) {
	float x = normal.x, y = normal.y, z = normal.z;
	vec3 result = shCoefficients[ 0 ] * 0.886227;
	result += shCoefficients[ 1 ] * 2.0 * 0.511664 * y;
	result += shCoefficients[ 2 ] * 2.0 * 0.511664 * z;
	result += shCoefficients[ 3 ] * 2.0 * 0.511664 * x;
	result += shCoefficients[ 4 ] * 2.0 * 0.429043 * x * y;
	result += shCoefficients[ 5 ] * 2.0 * 0.429043 * y * z;
	result += shCoefficients[ 6 ] * ( 0.743125 * z * z - 0.247708 );
	result += shCoefficients[ 7 ] * 2.0 * 0.429043 * x * z;
	result += shCoefficients[ 8 ] * 0.429043 * ( x * x - y * y );
	return result;
}
vec3 getLightProbeIrradiance( const in vec3 lightProbe[ 9 ], const in vec3 normal ) {
	vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec3 irradiance = shGetIrradianceAt( worldNormal, lightProbe );
	return irradiance;
}
vec3 getAmbientLightIrradiance( const in vec3 ambientLightColor ) {
	vec3 irradiance = ambientLightColor;
	return irradiance;
}
float getDistanceAttenuation( const in float lightDistance, const in float cutoffDistance, const in float decayExponent ) {
	float distanceFalloff = 1.0 / max( pow( lightDistance, decayExponent ), 0.01 );
	if ( cutoffDistance > 0.0 ) {
		distanceFalloff *= pow2( saturate( 1.0 - pow4( lightDistance / cutoffDistance ) ) );
	}
	return distanceFalloff;
}
float getSpotAttenuation( const in float coneCosine, const in float penumbraCosine, const in float angleCosine ) {
	return smoothstep( coneCosine, penumbraCosine, angleCosine );
}
#if NUM_SUN_LIGHTS > 0
	struct SunLight {
		vec3 direction;
		vec3 color;
	};
	uniform SunLight sunLights[ NUM_SUN_LIGHTS ];
	void getSunLightInfo( const in SunLight sunLight, out IncidentLight light ) {
		light.color = sunLight.color;
		light.direction = sunLight.direction;
		light.visible = true;
	}
#endif
#if NUM_DIR_LIGHTS > 0
	struct DirectionalLight {
		vec3 direction;
		vec3 color;
	};
	uniform DirectionalLight directionalLights[ NUM_DIR_LIGHTS ];
	void getDirectionalLightInfo( const in DirectionalLight directionalLight, out IncidentLight light ) {
		light.color = directionalLight.color;
		light.direction = directionalLight.direction;
		light.visible = true;
	}
#endif
#if NUM_POINT_LIGHTS > 0
	struct PointLight {
		vec3 position;
		vec3 color;
		float distance;
		float decay;
	};
	uniform PointLight pointLights[ NUM_POINT_LIGHTS ];
	void getPointLightInfo( const in PointLight pointLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = pointLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float lightDistance = length( lVector );
		light.color = pointLight.color;
		light.color *= getDistanceAttenuation( lightDistance, pointLight.distance, pointLight.decay );
		light.visible = ( light.color != vec3( 0.0 ) );
	}
#endif
#if NUM_SPOT_LIGHTS > 0
	struct SpotLight {
		vec3 position;
		vec3 direction;
		vec3 color;
		float distance;
		float decay;
		float coneCos;
		float penumbraCos;
	};
	uniform SpotLight spotLights[ NUM_SPOT_LIGHTS ];
	void getSpotLightInfo( const in SpotLight spotLight, const in vec3 geometryPosition, out IncidentLight light ) {
		vec3 lVector = spotLight.position - geometryPosition;
		light.direction = normalize( lVector );
		float angleCos = dot( light.direction, spotLight.direction );
		float spotAttenuation = getSpotAttenuation( spotLight.coneCos, spotLight.penumbraCos, angleCos );
		if ( spotAttenuation > 0.0 ) {
			float lightDistance = length( lVector );
			light.color = spotLight.color * spotAttenuation;
			light.color *= getDistanceAttenuation( lightDistance, spotLight.distance, spotLight.decay );
			light.visible = ( light.color != vec3( 0.0 ) );
		} else {
			light.color = vec3( 0.0 );
			light.visible = false;
		}
	}
#endif
#if NUM_RECT_AREA_LIGHTS > 0
	struct RectAreaLight {
		vec3 color;
		vec3 position;
		vec3 halfWidth;
		vec3 halfHeight;
	};
	uniform sampler2D ltc_1;	uniform sampler2D ltc_2;
	uniform RectAreaLight rectAreaLights[ NUM_RECT_AREA_LIGHTS ];
#endif
#if NUM_HEMI_LIGHTS > 0
	struct HemisphereLight {
		vec3 direction;
		vec3 skyColor;
		vec3 groundColor;
	};
	uniform HemisphereLight hemisphereLights[ NUM_HEMI_LIGHTS ];
	vec3 getHemisphereLightIrradiance( const in HemisphereLight hemiLight, const in vec3 normal ) {
		float dotNL = dot( normal, hemiLight.direction );
		float hemiDiffuseWeight = 0.5 * dotNL + 0.5;
		vec3 irradiance = mix( hemiLight.groundColor, hemiLight.skyColor, hemiDiffuseWeight );
		return irradiance;
	}
#endif
#include <lightprobes_pars_fragment>`,s0=`#ifdef USE_ENVMAP
	vec3 getIBLIrradiance( const in vec3 normal ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 worldNormal = transformNormalByInverseViewMatrix( normal, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * worldNormal, ENVMAP_MAX_LOD );
			return PI * envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	vec3 getIBLRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
		#ifdef ENVMAP_TYPE_PMREM
			vec3 reflectVec = reflect( - viewDir, normal );
			reflectVec = normalize( mix( reflectVec, normal, pow4( roughness ) ) );
			reflectVec = transformDirectionByInverseViewMatrix( reflectVec, viewMatrix );
			vec4 envMapColor = textureLod( envMap, envMapRotation * reflectVec, roughnessToMip( roughness ) );
			return envMapColor.rgb * envMapIntensity;
		#else
			return vec3( 0.0 );
		#endif
	}
	#ifdef USE_RETROREFLECTION
		vec3 getIBLRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 retroVec = normalize( mix( viewDir, normal, pow4( roughness ) ) );
				retroVec = transformDirectionByInverseViewMatrix( retroVec, viewMatrix );
				vec4 envMapColor = textureLod( envMap, envMapRotation * retroVec, roughnessToMip( roughness ) );
				return envMapColor.rgb * envMapIntensity;
			#else
				return vec3( 0.0 );
			#endif
		}
	#endif
	#ifdef USE_ANISOTROPY
		vec3 getIBLAnisotropyRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
			#ifdef ENVMAP_TYPE_PMREM
				vec3 bentNormal = cross( bitangent, viewDir );
				bentNormal = normalize( cross( bentNormal, bitangent ) );
				bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
				return getIBLRadiance( viewDir, bentNormal, roughness );
			#else
				return vec3( 0.0 );
			#endif
		}
		#ifdef USE_RETROREFLECTION
			vec3 getIBLAnisotropyRetroRadiance( const in vec3 viewDir, const in vec3 normal, const in float roughness, const in vec3 bitangent, const in float anisotropy ) {
				#ifdef ENVMAP_TYPE_PMREM
					vec3 bentNormal = cross( bitangent, viewDir );
					bentNormal = normalize( cross( bentNormal, bitangent ) );
					bentNormal = normalize( mix( bentNormal, normal, pow2( pow2( 1.0 - anisotropy * ( 1.0 - roughness ) ) ) ) );
					return getIBLRetroRadiance( viewDir, bentNormal, roughness );
				#else
					return vec3( 0.0 );
				#endif
			}
		#endif
	#endif
#endif`,a0=`ToonMaterial material;
material.diffuseColor = diffuseColor.rgb;`,o0=`varying vec3 vViewPosition;
struct ToonMaterial {
	vec3 diffuseColor;
};
void RE_Direct_Toon( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 irradiance = getGradientIrradiance( geometryNormal, directLight.direction ) * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
void RE_IndirectDiffuse_Toon( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in ToonMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_Toon
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Toon`,l0=`BlinnPhongMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.specularColor = specular;
material.specularShininess = shininess;
material.specularStrength = specularStrength;`,c0=`varying vec3 vViewPosition;
struct BlinnPhongMaterial {
	vec3 diffuseColor;
	vec3 specularColor;
	float specularShininess;
	float specularStrength;
};
void RE_Direct_BlinnPhong( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	reflectedLight.directDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
	reflectedLight.directSpecular += irradiance * BRDF_BlinnPhong( directLight.direction, geometryViewDir, geometryNormal, material.specularColor, material.specularShininess ) * material.specularStrength;
}
void RE_IndirectDiffuse_BlinnPhong( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in BlinnPhongMaterial material, inout ReflectedLight reflectedLight ) {
	reflectedLight.indirectDiffuse += irradiance * BRDF_Lambert( material.diffuseColor );
}
#define RE_Direct				RE_Direct_BlinnPhong
#define RE_IndirectDiffuse		RE_IndirectDiffuse_BlinnPhong`,h0=`PhysicalMaterial material;
material.diffuseColor = diffuseColor.rgb;
material.diffuseContribution = diffuseColor.rgb * ( 1.0 - metalnessFactor );
material.metalness = metalnessFactor;
vec3 dxy = max( abs( dFdx( nonPerturbedNormal ) ), abs( dFdy( nonPerturbedNormal ) ) );
float geometryRoughness = max( max( dxy.x, dxy.y ), dxy.z );
material.roughness = max( roughnessFactor, 0.045 );
material.roughness += geometryRoughness;
material.roughness = min( material.roughness, 1.0 );
#ifdef USE_DIFFUSE_ROUGHNESS
	float diffuseRoughnessFactor = diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		diffuseRoughnessFactor *= texture2D( diffuseRoughnessMap, vDiffuseRoughnessMapUv ).r;
	#endif
	material.diffuseRoughness = saturate( diffuseRoughnessFactor );
#endif
#ifdef IOR
	material.ior = ior;
	#ifdef USE_SPECULAR
		float specularIntensityFactor = specularIntensity;
		vec3 specularColorFactor = specularColor;
		#ifdef USE_SPECULAR_COLORMAP
			specularColorFactor *= texture2D( specularColorMap, vSpecularColorMapUv ).rgb;
		#endif
		#ifdef USE_SPECULAR_INTENSITYMAP
			specularIntensityFactor *= texture2D( specularIntensityMap, vSpecularIntensityMapUv ).a;
		#endif
		material.specularF90 = mix( specularIntensityFactor, 1.0, metalnessFactor );
	#else
		float specularIntensityFactor = 1.0;
		vec3 specularColorFactor = vec3( 1.0 );
		material.specularF90 = 1.0;
	#endif
	material.specularColor = min( pow2( ( material.ior - 1.0 ) / ( material.ior + 1.0 ) ) * specularColorFactor, vec3( 1.0 ) ) * specularIntensityFactor;
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
#else
	material.specularColor = vec3( 0.04 );
	material.specularColorBlended = mix( material.specularColor, diffuseColor.rgb, metalnessFactor );
	material.specularF90 = 1.0;
#endif
#ifdef USE_CLEARCOAT
	material.clearcoat = clearcoat;
	material.clearcoatRoughness = clearcoatRoughness;
	material.clearcoatF0 = vec3( 0.04 );
	material.clearcoatF90 = 1.0;
	#ifdef USE_CLEARCOATMAP
		material.clearcoat *= texture2D( clearcoatMap, vClearcoatMapUv ).x;
	#endif
	#ifdef USE_CLEARCOAT_ROUGHNESSMAP
		material.clearcoatRoughness *= texture2D( clearcoatRoughnessMap, vClearcoatRoughnessMapUv ).y;
	#endif
	material.clearcoat = saturate( material.clearcoat );	material.clearcoatRoughness = max( material.clearcoatRoughness, 0.045 );
	material.clearcoatRoughness += geometryRoughness;
	material.clearcoatRoughness = min( material.clearcoatRoughness, 1.0 );
#endif
#ifdef USE_DISPERSION
	material.dispersion = dispersion;
#endif
#ifdef USE_RETROREFLECTION
	material.retroreflectivity = retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	material.iridescence = iridescence;
	material.iridescenceIOR = iridescenceIOR;
	#ifdef USE_IRIDESCENCEMAP
		material.iridescence *= texture2D( iridescenceMap, vIridescenceMapUv ).r;
	#endif
	#ifdef USE_IRIDESCENCE_THICKNESSMAP
		material.iridescenceThickness = (iridescenceThicknessMaximum - iridescenceThicknessMinimum) * texture2D( iridescenceThicknessMap, vIridescenceThicknessMapUv ).g + iridescenceThicknessMinimum;
	#else
		material.iridescenceThickness = iridescenceThicknessMaximum;
	#endif
#endif
#ifdef USE_SHEEN
	material.sheenColor = sheenColor;
	#ifdef USE_SHEEN_COLORMAP
		material.sheenColor *= texture2D( sheenColorMap, vSheenColorMapUv ).rgb;
	#endif
	material.sheenRoughness = clamp( sheenRoughness, 0.0001, 1.0 );
	#ifdef USE_SHEEN_ROUGHNESSMAP
		material.sheenRoughness *= texture2D( sheenRoughnessMap, vSheenRoughnessMapUv ).a;
	#endif
#endif
#ifdef USE_ANISOTROPY
	#ifdef USE_ANISOTROPYMAP
		mat2 anisotropyMat = mat2( anisotropyVector.x, anisotropyVector.y, - anisotropyVector.y, anisotropyVector.x );
		vec3 anisotropyPolar = texture2D( anisotropyMap, vAnisotropyMapUv ).rgb;
		vec2 anisotropyV = anisotropyMat * normalize( 2.0 * anisotropyPolar.rg - vec2( 1.0 ) ) * anisotropyPolar.b;
	#else
		vec2 anisotropyV = anisotropyVector;
	#endif
	material.anisotropy = length( anisotropyV );
	if( material.anisotropy == 0.0 ) {
		anisotropyV = vec2( 1.0, 0.0 );
	} else {
		anisotropyV /= material.anisotropy;
		material.anisotropy = saturate( material.anisotropy );
	}
	material.alphaT = mix( pow2( material.roughness ), 1.0, pow2( material.anisotropy ) );
	material.anisotropyT = tbn[ 0 ] * anisotropyV.x + tbn[ 1 ] * anisotropyV.y;
	material.anisotropyB = tbn[ 1 ] * anisotropyV.x - tbn[ 0 ] * anisotropyV.y;
#endif`,u0=`uniform sampler2D dfgLUT;
struct PhysicalMaterial {
	vec3 diffuseColor;
	vec3 diffuseContribution;
	vec3 specularColor;
	vec3 specularColorBlended;
	float roughness;
	float metalness;
	float specularF90;
	float dispersion;
	vec2 dfg;
	vec3 multiScatteringCompensation;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float diffuseRoughness;
	#endif
	#ifdef USE_RETROREFLECTION
		float retroreflectivity;
	#endif
	#ifdef USE_CLEARCOAT
		float clearcoat;
		float clearcoatRoughness;
		vec3 clearcoatF0;
		float clearcoatF90;
	#endif
	#ifdef USE_IRIDESCENCE
		float iridescence;
		float iridescenceIOR;
		float iridescenceThickness;
		vec3 iridescenceFresnel;
		vec3 iridescenceF0Dielectric;
		vec3 iridescenceF0Metallic;
	#endif
	#ifdef USE_SHEEN
		vec3 sheenColor;
		float sheenRoughness;
	#endif
	#ifdef IOR
		float ior;
	#endif
	#ifdef USE_TRANSMISSION
		float transmission;
		float transmissionAlpha;
		float thickness;
		float attenuationDistance;
		vec3 attenuationColor;
	#endif
	#ifdef USE_ANISOTROPY
		float anisotropy;
		float alphaT;
		vec3 anisotropyT;
		vec3 anisotropyB;
	#endif
};
vec3 clearcoatSpecularDirect = vec3( 0.0 );
vec3 clearcoatSpecularIndirect = vec3( 0.0 );
vec3 sheenSpecularDirect = vec3( 0.0 );
vec3 sheenSpecularIndirect = vec3(0.0 );
vec3 Schlick_to_F0( const in vec3 f, const in float f90, const in float dotVH ) {
    float x = clamp( 1.0 - dotVH, 0.0, 1.0 );
    float x2 = x * x;
    float x5 = clamp( x * x2 * x2, 0.0, 0.9999 );
    return ( f - vec3( f90 ) * x5 ) / ( 1.0 - x5 );
}
#ifdef USE_DIFFUSE_ROUGHNESS
	const float EON_EPSILON = 1e-7;
	float FON_DirectionalAlbedo( const in float mu, const in float roughness, const in float A ) {
		float muComp = 1.0 - mu;
		float gOverPi = muComp * ( 0.0571085289 + muComp * ( 0.491881867 + muComp * ( - 0.332181442 + muComp * 0.0714429953 ) ) );
		return A * ( 1.0 + roughness * gOverPi );
	}
	vec3 BRDF_EON( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in vec3 diffuseColor, const in float roughness ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return BRDF_Lambert( rho );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float s = dot( lightDir, viewDir ) - dotNL * dotNV;
		float sOverT = ( s > 0.0 ) ? s / max( max( dotNL, dotNV ), EON_EPSILON ) : s;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		vec3 singleScatter = rho * RECIPROCAL_PI * A * ( 1.0 + roughness * sOverT );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		float albedoV = FON_DirectionalAlbedo( dotNV, roughness, A );
		float albedoL = FON_DirectionalAlbedo( dotNL, roughness, A );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		vec3 multiScatter = rhoMultiScatter * RECIPROCAL_PI
			* max( EON_EPSILON, 1.0 - albedoV )
			* max( EON_EPSILON, 1.0 - albedoL )
			/ max( EON_EPSILON, 1.0 - averageAlbedo );
		return singleScatter + multiScatter;
	}
	vec3 EON_DirectionalAlbedo( const in vec3 diffuseColor, const in float roughness, const in float dotNV ) {
		vec3 rho = saturate( diffuseColor );
		if ( roughness <= EON_EPSILON ) return rho;
		float A = 1.0 / ( 1.0 + ( 0.5 - 2.0 / ( 3.0 * PI ) ) * roughness );
		float directionalAlbedo = FON_DirectionalAlbedo( dotNV, roughness, A );
		float averageAlbedo = A * ( 1.0 + ( 2.0 / 3.0 - 28.0 / ( 15.0 * PI ) ) * roughness );
		vec3 rhoMultiScatter = rho * rho * averageAlbedo / max( vec3( EON_EPSILON ), vec3( 1.0 ) - rho * ( 1.0 - averageAlbedo ) );
		return rho * directionalAlbedo + rhoMultiScatter * ( 1.0 - directionalAlbedo );
	}
#endif
float V_GGX_SmithCorrelated( const in float alpha, const in float dotNL, const in float dotNV ) {
	float a2 = pow2( alpha );
	float gv = dotNL * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNV ) );
	float gl = dotNV * sqrt( a2 + ( 1.0 - a2 ) * pow2( dotNL ) );
	return 0.5 / max( gv + gl, EPSILON );
}
float D_GGX( const in float alpha, const in float dotNH ) {
	float a2 = pow2( alpha );
	float denom = pow2( dotNH ) * ( a2 - 1.0 ) + 1.0;
	return RECIPROCAL_PI * a2 / pow2( denom );
}
#ifdef USE_ANISOTROPY
	float V_GGX_SmithCorrelated_Anisotropic( const in float alphaT, const in float alphaB, const in float dotTV, const in float dotBV, const in float dotTL, const in float dotBL, const in float dotNV, const in float dotNL ) {
		float gv = dotNL * length( vec3( alphaT * dotTV, alphaB * dotBV, dotNV ) );
		float gl = dotNV * length( vec3( alphaT * dotTL, alphaB * dotBL, dotNL ) );
		return 0.5 / max( gv + gl, EPSILON );
	}
	float D_GGX_Anisotropic( const in float alphaT, const in float alphaB, const in float dotNH, const in float dotTH, const in float dotBH ) {
		float a2 = alphaT * alphaB;
		highp vec3 v = vec3( alphaB * dotTH, alphaT * dotBH, a2 * dotNH );
		highp float v2 = dot( v, v );
		float w2 = a2 / v2;
		return RECIPROCAL_PI * a2 * pow2 ( w2 );
	}
#endif
#ifdef USE_CLEARCOAT
	vec3 BRDF_GGX_Clearcoat( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material) {
		vec3 f0 = material.clearcoatF0;
		float f90 = material.clearcoatF90;
		float roughness = max( material.clearcoatRoughness, 0.045 );
		float alpha = pow2( roughness );
		vec3 halfDir = normalize( lightDir + viewDir );
		float dotNL = saturate( dot( normal, lightDir ) );
		float dotNV = saturate( dot( normal, viewDir ) );
		float dotNH = saturate( dot( normal, halfDir ) );
		float dotVH = saturate( dot( viewDir, halfDir ) );
		vec3 F = F_Schlick( f0, f90, dotVH );
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
		return F * ( V * D );
	}
#endif
vec3 BRDF_GGX( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, const in PhysicalMaterial material ) {
	vec3 f0 = material.specularColorBlended;
	float f90 = material.specularF90;
	float roughness = max( material.roughness, 0.045 );
	float alpha = pow2( roughness );
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float dotVH = saturate( dot( viewDir, halfDir ) );
	vec3 F = F_Schlick( f0, f90, dotVH );
	#ifdef USE_IRIDESCENCE
		F = mix( F, material.iridescenceFresnel, material.iridescence );
	#endif
	#ifdef USE_ANISOTROPY
		float dotTL = dot( material.anisotropyT, lightDir );
		float dotTV = dot( material.anisotropyT, viewDir );
		float dotTH = dot( material.anisotropyT, halfDir );
		float dotBL = dot( material.anisotropyB, lightDir );
		float dotBV = dot( material.anisotropyB, viewDir );
		float dotBH = dot( material.anisotropyB, halfDir );
		float alphaT = max( material.alphaT, alpha );
		float V = V_GGX_SmithCorrelated_Anisotropic( alphaT, alpha, dotTV, dotBV, dotTL, dotBL, dotNV, dotNL );
		float D = D_GGX_Anisotropic( alphaT, alpha, dotNH, dotTH, dotBH );
	#else
		float V = V_GGX_SmithCorrelated( alpha, dotNL, dotNV );
		float D = D_GGX( alpha, dotNH );
	#endif
	return F * ( V * D );
}
vec2 LTC_Uv( const in vec3 N, const in vec3 V, const in float roughness ) {
	const float LUT_SIZE = 64.0;
	const float LUT_SCALE = ( LUT_SIZE - 1.0 ) / LUT_SIZE;
	const float LUT_BIAS = 0.5 / LUT_SIZE;
	float dotNV = saturate( dot( N, V ) );
	vec2 uv = vec2( roughness, sqrt( 1.0 - dotNV ) );
	uv = uv * LUT_SCALE + LUT_BIAS;
	return uv;
}
float LTC_ClippedSphereFormFactor( const in vec3 f ) {
	float l = length( f );
	return max( ( l * l + f.z ) / ( l + 1.0 ), 0.0 );
}
vec3 LTC_EdgeVectorFormFactor( const in vec3 v1, const in vec3 v2 ) {
	float x = dot( v1, v2 );
	float y = abs( x );
	float a = 0.8543985 + ( 0.4965155 + 0.0145206 * y ) * y;
	float b = 3.4175940 + ( 4.1616724 + y ) * y;
	float v = a / b;
	float theta_sintheta = ( x > 0.0 ) ? v : 0.5 * inversesqrt( max( 1.0 - x * x, 1e-7 ) ) - v;
	return cross( v1, v2 ) * theta_sintheta;
}
vec3 LTC_Evaluate( const in vec3 N, const in vec3 V, const in vec3 P, const in mat3 mInv, const in vec3 rectCoords[ 4 ] ) {
	vec3 v1 = rectCoords[ 1 ] - rectCoords[ 0 ];
	vec3 v2 = rectCoords[ 3 ] - rectCoords[ 0 ];
	vec3 lightNormal = cross( v1, v2 );
	if( dot( lightNormal, P - rectCoords[ 0 ] ) < 0.0 ) return vec3( 0.0 );
	vec3 T1, T2;
	T1 = normalize( V - N * dot( V, N ) );
	T2 = - cross( N, T1 );
	mat3 mat = mInv * transpose( mat3( T1, T2, N ) );
	vec3 coords[ 4 ];
	coords[ 0 ] = mat * ( rectCoords[ 0 ] - P );
	coords[ 1 ] = mat * ( rectCoords[ 1 ] - P );
	coords[ 2 ] = mat * ( rectCoords[ 2 ] - P );
	coords[ 3 ] = mat * ( rectCoords[ 3 ] - P );
	coords[ 0 ] = normalize( coords[ 0 ] );
	coords[ 1 ] = normalize( coords[ 1 ] );
	coords[ 2 ] = normalize( coords[ 2 ] );
	coords[ 3 ] = normalize( coords[ 3 ] );
	vec3 vectorFormFactor = vec3( 0.0 );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 0 ], coords[ 1 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 1 ], coords[ 2 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 2 ], coords[ 3 ] );
	vectorFormFactor += LTC_EdgeVectorFormFactor( coords[ 3 ], coords[ 0 ] );
	float result = LTC_ClippedSphereFormFactor( vectorFormFactor );
	return vec3( result );
}
#if defined( USE_SHEEN )
float D_Charlie( float roughness, float dotNH ) {
	float alpha = pow2( roughness );
	float invAlpha = 1.0 / alpha;
	float cos2h = dotNH * dotNH;
	float sin2h = max( 1.0 - cos2h, 0.0078125 );
	return ( 2.0 + invAlpha ) * pow( sin2h, invAlpha * 0.5 ) / ( 2.0 * PI );
}
float V_Neubelt( float dotNV, float dotNL ) {
	return saturate( 1.0 / ( 4.0 * ( dotNL + dotNV - dotNL * dotNV ) ) );
}
vec3 BRDF_Sheen( const in vec3 lightDir, const in vec3 viewDir, const in vec3 normal, vec3 sheenColor, const in float sheenRoughness ) {
	vec3 halfDir = normalize( lightDir + viewDir );
	float dotNL = saturate( dot( normal, lightDir ) );
	float dotNV = saturate( dot( normal, viewDir ) );
	float dotNH = saturate( dot( normal, halfDir ) );
	float D = D_Charlie( sheenRoughness, dotNH );
	float V = V_Neubelt( dotNV, dotNL );
	return sheenColor * ( D * V );
}
#endif
float IBLSheenBRDF( const in vec3 normal, const in vec3 viewDir, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	float r2 = roughness * roughness;
	float rInv = 1.0 / ( roughness + 0.1 );
	float a = -1.9362 + 1.0678 * roughness + 0.4573 * r2 - 0.8469 * rInv;
	float b = -0.6014 + 0.5538 * roughness - 0.4670 * r2 - 0.1255 * rInv;
	float DG = exp( a * dotNV + b );
	return saturate( DG );
}
vec3 EnvironmentBRDF( const in vec3 normal, const in vec3 viewDir, const in vec3 specularColor, const in float specularF90, const in float roughness ) {
	float dotNV = saturate( dot( normal, viewDir ) );
	vec2 fab = texture2D( dfgLUT, vec2( roughness, dotNV ) ).rg;
	return specularColor * fab.x + specularF90 * fab.y;
}
#ifdef USE_IRIDESCENCE
void computeMultiscatteringIridescence( const in vec2 fab, const in vec3 specularColor, const in float specularF90, const in float iridescence, const in vec3 iridescenceF0, inout vec3 singleScatter, inout vec3 multiScatter ) {
#else
void computeMultiscattering( const in vec2 fab, const in vec3 specularColor, const in float specularF90, inout vec3 singleScatter, inout vec3 multiScatter ) {
#endif
	#ifdef USE_IRIDESCENCE
		vec3 Fr = mix( specularColor, iridescenceF0, iridescence );
	#else
		vec3 Fr = specularColor;
	#endif
	vec3 FssEss = Fr * fab.x + specularF90 * fab.y;
	float Ess = fab.x + fab.y;
	float Ems = 1.0 - Ess;
	vec3 Favg = Fr + ( 1.0 - Fr ) * 0.047619;	vec3 Fms = FssEss * Favg / ( 1.0 - Ems * Favg );
	singleScatter += FssEss;
	multiScatter += Fms * Ems;
}
#if NUM_RECT_AREA_LIGHTS > 0
	void RE_Direct_RectArea_Physical( const in RectAreaLight rectAreaLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
		vec3 normal = geometryNormal;
		vec3 viewDir = geometryViewDir;
		vec3 position = geometryPosition;
		vec3 lightPos = rectAreaLight.position;
		vec3 halfWidth = rectAreaLight.halfWidth;
		vec3 halfHeight = rectAreaLight.halfHeight;
		vec3 lightColor = rectAreaLight.color;
		float roughness = material.roughness;
		vec3 rectCoords[ 4 ];
		rectCoords[ 0 ] = lightPos + halfWidth - halfHeight;		rectCoords[ 1 ] = lightPos - halfWidth - halfHeight;
		rectCoords[ 2 ] = lightPos - halfWidth + halfHeight;
		rectCoords[ 3 ] = lightPos + halfWidth + halfHeight;
		vec2 uv = LTC_Uv( normal, viewDir, roughness );
		vec4 t1 = texture2D( ltc_1, uv );
		vec4 t2 = texture2D( ltc_2, uv );
		mat3 mInv = mat3(
			vec3( t1.x, 0, t1.y ),
			vec3(    0, 1,    0 ),
			vec3( t1.z, 0, t1.w )
		);
		vec3 fresnel = ( material.specularColorBlended * t2.x + ( material.specularF90 - material.specularColorBlended ) * t2.y );
		reflectedLight.directSpecular += lightColor * fresnel * LTC_Evaluate( normal, viewDir, position, mInv, rectCoords );
		reflectedLight.directDiffuse += lightColor * material.diffuseContribution * LTC_Evaluate( normal, viewDir, position, mat3( 1.0 ), rectCoords );
		#ifdef USE_CLEARCOAT
			vec3 Ncc = geometryClearcoatNormal;
			vec2 uvClearcoat = LTC_Uv( Ncc, viewDir, material.clearcoatRoughness );
			vec4 t1Clearcoat = texture2D( ltc_1, uvClearcoat );
			vec4 t2Clearcoat = texture2D( ltc_2, uvClearcoat );
			mat3 mInvClearcoat = mat3(
				vec3( t1Clearcoat.x, 0, t1Clearcoat.y ),
				vec3(             0, 1,             0 ),
				vec3( t1Clearcoat.z, 0, t1Clearcoat.w )
			);
			vec3 fresnelClearcoat = material.clearcoatF0 * t2Clearcoat.x + ( material.clearcoatF90 - material.clearcoatF0 ) * t2Clearcoat.y;
			clearcoatSpecularDirect += lightColor * fresnelClearcoat * LTC_Evaluate( Ncc, viewDir, position, mInvClearcoat, rectCoords );
		#endif
	}
#endif
void RE_Direct_Physical( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	float dotNL = saturate( dot( geometryNormal, directLight.direction ) );
	vec3 irradiance = dotNL * directLight.color;
	#ifdef USE_CLEARCOAT
		float dotNLcc = saturate( dot( geometryClearcoatNormal, directLight.direction ) );
		vec3 ccIrradiance = dotNLcc * directLight.color;
		clearcoatSpecularDirect += ccIrradiance * BRDF_GGX_Clearcoat( directLight.direction, geometryViewDir, geometryClearcoatNormal, material );
	#endif
	#ifdef USE_SHEEN
 
 		sheenSpecularDirect += irradiance * BRDF_Sheen( directLight.direction, geometryViewDir, geometryNormal, material.sheenColor, material.sheenRoughness );
 
 		float sheenAlbedoV = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
 		float sheenAlbedoL = IBLSheenBRDF( geometryNormal, directLight.direction, material.sheenRoughness );
 
 		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * max( sheenAlbedoV, sheenAlbedoL );
 
 		irradiance *= sheenEnergyComp;
 
 	#endif
	vec3 specularBRDF = BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, material );
	#ifdef USE_RETROREFLECTION
		vec3 retroViewDir = reflect( - geometryViewDir, geometryNormal );
		vec3 retroSpecularBRDF = BRDF_GGX( directLight.direction, retroViewDir, geometryNormal, material );
		specularBRDF = mix( specularBRDF, retroSpecularBRDF, saturate( material.retroreflectivity ) );
	#endif
	reflectedLight.directSpecular += irradiance * specularBRDF * material.multiScatteringCompensation;
	vec3 halfDir = normalize( directLight.direction + geometryViewDir );
	float dotVH = saturate( dot( geometryViewDir, halfDir ) );
	vec3 F = F_Schlick( material.specularColor, material.specularF90, dotVH );
	#ifdef USE_RETROREFLECTION
		vec3 retroHalfDir = normalize( directLight.direction + retroViewDir );
		float dotRetroVH = saturate( dot( retroViewDir, retroHalfDir ) );
		vec3 retroF = F_Schlick( material.specularColor, material.specularF90, dotRetroVH );
		F = mix( F, retroF, saturate( material.retroreflectivity ) );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		vec3 diffuseBRDF = BRDF_EON( directLight.direction, geometryViewDir, geometryNormal, material.diffuseColor, material.diffuseRoughness ) * ( 1.0 - material.metalness );
	#else
		vec3 diffuseBRDF = BRDF_Lambert( material.diffuseContribution );
	#endif
	reflectedLight.directDiffuse += irradiance * diffuseBRDF * ( 1.0 - F );
}
void RE_IndirectDiffuse_Physical( const in vec3 irradiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
	vec3 singleScattering = vec3( 0.0 );
	vec3 multiScattering = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScattering, multiScattering );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScattering, multiScattering );
	#endif
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuseAlbedo = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness );
		vec3 diffuse = irradiance * RECIPROCAL_PI * diffuseAlbedo * ( 1.0 - singleScattering - multiScattering );
	#else
		vec3 diffuse = irradiance * BRDF_Lambert( material.diffuseContribution ) * ( 1.0 - singleScattering - multiScattering );
	#endif
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		sheenSpecularIndirect += irradiance * material.sheenColor * sheenAlbedo * RECIPROCAL_PI;
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		diffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectDiffuse += diffuse;
}
void RE_IndirectSpecular_Physical( const in vec3 radiance, const in vec3 irradiance, const in vec3 clearcoatRadiance, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight) {
	#ifdef USE_CLEARCOAT
		clearcoatSpecularIndirect += clearcoatRadiance * EnvironmentBRDF( geometryClearcoatNormal, geometryViewDir, material.clearcoatF0, material.clearcoatF90, material.clearcoatRoughness );
	#endif
	#ifdef USE_SHEEN
		sheenSpecularIndirect += irradiance * material.sheenColor * IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness ) * RECIPROCAL_PI;
 	#endif
	vec3 singleScatteringDielectric = vec3( 0.0 );
	vec3 multiScatteringDielectric = vec3( 0.0 );
	vec3 singleScatteringMetallic = vec3( 0.0 );
	vec3 multiScatteringMetallic = vec3( 0.0 );
	#ifdef USE_IRIDESCENCE
		computeMultiscatteringIridescence( material.dfg, material.specularColor, material.specularF90, material.iridescence, material.iridescenceF0Dielectric, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscatteringIridescence( material.dfg, material.diffuseColor, material.specularF90, material.iridescence, material.iridescenceF0Metallic, singleScatteringMetallic, multiScatteringMetallic );
	#else
		computeMultiscattering( material.dfg, material.specularColor, material.specularF90, singleScatteringDielectric, multiScatteringDielectric );
		computeMultiscattering( material.dfg, material.diffuseColor, material.specularF90, singleScatteringMetallic, multiScatteringMetallic );
	#endif
	vec3 singleScattering = mix( singleScatteringDielectric, singleScatteringMetallic, material.metalness );
	vec3 multiScattering = mix( multiScatteringDielectric, multiScatteringMetallic, material.metalness );
	vec3 totalScatteringDielectric = singleScatteringDielectric + multiScatteringDielectric;
	#ifdef USE_DIFFUSE_ROUGHNESS
		float dotNV = saturate( dot( geometryNormal, geometryViewDir ) );
		vec3 diffuse = EON_DirectionalAlbedo( material.diffuseColor, material.diffuseRoughness, dotNV ) * ( 1.0 - material.metalness ) * ( 1.0 - totalScatteringDielectric );
	#else
		vec3 diffuse = material.diffuseContribution * ( 1.0 - totalScatteringDielectric );
	#endif
	vec3 cosineWeightedIrradiance = irradiance * RECIPROCAL_PI;
	vec3 indirectSpecular = radiance * singleScattering;
	indirectSpecular += multiScattering * cosineWeightedIrradiance;
	vec3 indirectDiffuse = diffuse * cosineWeightedIrradiance;
	#ifdef USE_SHEEN
		float sheenAlbedo = IBLSheenBRDF( geometryNormal, geometryViewDir, material.sheenRoughness );
		float sheenEnergyComp = 1.0 - max3( material.sheenColor ) * sheenAlbedo;
		indirectSpecular *= sheenEnergyComp;
		indirectDiffuse *= sheenEnergyComp;
	#endif
	reflectedLight.indirectSpecular += indirectSpecular;
	reflectedLight.indirectDiffuse += indirectDiffuse;
}
#define RE_Direct				RE_Direct_Physical
#define RE_Direct_RectArea		RE_Direct_RectArea_Physical
#define RE_IndirectDiffuse		RE_IndirectDiffuse_Physical
#define RE_IndirectSpecular		RE_IndirectSpecular_Physical
float computeSpecularOcclusion( const in float dotNV, const in float ambientOcclusion, const in float roughness ) {
	return saturate( pow( dotNV + ambientOcclusion, exp2( - 16.0 * roughness - 1.0 ) ) - 1.0 + ambientOcclusion );
}`,f0=`
vec3 geometryPosition = - vViewPosition;
vec3 geometryNormal = normal;
vec3 geometryViewDir = ( isOrthographic ) ? vec3( 0, 0, 1 ) : normalize( vViewPosition );
vec3 geometryClearcoatNormal = vec3( 0.0 );
#ifdef USE_CLEARCOAT
	geometryClearcoatNormal = clearcoatNormal;
#endif
#ifdef USE_IRIDESCENCE
	float dotNVi = saturate( dot( normal, geometryViewDir ) );
	if ( material.iridescenceThickness == 0.0 ) {
		material.iridescence = 0.0;
	} else {
		material.iridescence = saturate( material.iridescence );
	}
	if ( material.iridescence > 0.0 ) {
		vec3 iridescenceFresnelDielectric = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.specularColor );
		vec3 iridescenceFresnelMetallic = evalIridescence( 1.0, material.iridescenceIOR, dotNVi, material.iridescenceThickness, material.diffuseColor );
		material.iridescenceFresnel = mix( iridescenceFresnelDielectric, iridescenceFresnelMetallic, material.metalness );
		material.iridescenceF0Dielectric = Schlick_to_F0( iridescenceFresnelDielectric, 1.0, dotNVi );
		material.iridescenceF0Metallic = Schlick_to_F0( iridescenceFresnelMetallic, 1.0, dotNVi );
	}
#endif
#ifdef STANDARD
	float dotNVms = saturate( dot( geometryNormal, geometryViewDir ) );
	material.dfg = texture2D( dfgLUT, vec2( material.roughness, dotNVms ) ).rg;
	#if ( NUM_SUN_LIGHTS > 0 || NUM_DIR_LIGHTS > 0 || NUM_POINT_LIGHTS > 0 || NUM_SPOT_LIGHTS > 0 )
		float EssMs = material.dfg.x + material.dfg.y;
		material.multiScatteringCompensation = 1.0 + material.specularColorBlended * ( 1.0 / EssMs - 1.0 );
	#endif
#endif
IncidentLight directLight;
#if ( NUM_POINT_LIGHTS > 0 ) && defined( RE_Direct )
	PointLight pointLight;
	#if defined( USE_SHADOWMAP ) && NUM_POINT_LIGHT_SHADOWS > 0
	PointLightShadow pointLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHTS; i ++ ) {
		pointLight = pointLights[ i ];
		getPointLightInfo( pointLight, geometryPosition, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_POINT_LIGHT_SHADOWS ) && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
		pointLightShadow = pointLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getPointShadow( pointShadowMap[ i ], pointLightShadow.shadowMapSize, pointLightShadow.shadowIntensity, pointLightShadow.shadowBias, pointLightShadow.shadowRadius, vPointShadowCoord[ i ], pointLightShadow.shadowCameraNear, pointLightShadow.shadowCameraFar ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SPOT_LIGHTS > 0 ) && defined( RE_Direct )
	SpotLight spotLight;
	vec4 spotColor;
	vec3 spotLightCoord;
	bool inSpotLightMap;
	#if defined( USE_SHADOWMAP ) && NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHTS; i ++ ) {
		spotLight = spotLights[ i ];
		getSpotLightInfo( spotLight, geometryPosition, directLight );
		#if ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#define SPOT_LIGHT_MAP_INDEX UNROLLED_LOOP_INDEX
		#elif ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		#define SPOT_LIGHT_MAP_INDEX NUM_SPOT_LIGHT_MAPS
		#else
		#define SPOT_LIGHT_MAP_INDEX ( UNROLLED_LOOP_INDEX - NUM_SPOT_LIGHT_SHADOWS + NUM_SPOT_LIGHT_SHADOWS_WITH_MAPS )
		#endif
		#if ( SPOT_LIGHT_MAP_INDEX < NUM_SPOT_LIGHT_MAPS )
			spotLightCoord = vSpotLightCoord[ i ].xyz / vSpotLightCoord[ i ].w;
			inSpotLightMap = all( lessThan( abs( spotLightCoord * 2. - 1. ), vec3( 1.0 ) ) );
			spotColor = texture2D( spotLightMap[ SPOT_LIGHT_MAP_INDEX ], spotLightCoord.xy );
			directLight.color = inSpotLightMap ? directLight.color * spotColor.rgb : directLight.color;
		#endif
		#undef SPOT_LIGHT_MAP_INDEX
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
		spotLightShadow = spotLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( spotShadowMap[ i ], spotLightShadow.shadowMapSize, spotLightShadow.shadowIntensity, spotLightShadow.shadowBias, spotLightShadow.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_SUN_LIGHTS > 0 ) && defined( RE_Direct )
	SunLight sunLight;
	#if defined( USE_SHADOWMAP ) && NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHTS; i ++ ) {
		sunLight = sunLights[ i ];
		getSunLightInfo( sunLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_SUN_LIGHT_SHADOWS )
		sunLightShadow = sunLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getSunShadow( sunShadowMap[ i ], sunLightShadow, UNROLLED_LOOP_INDEX ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_DIR_LIGHTS > 0 ) && defined( RE_Direct )
	DirectionalLight directionalLight;
	#if defined( USE_SHADOWMAP ) && NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLightShadow;
	#endif
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHTS; i ++ ) {
		directionalLight = directionalLights[ i ];
		getDirectionalLightInfo( directionalLight, directLight );
		#if defined( USE_SHADOWMAP ) && ( UNROLLED_LOOP_INDEX < NUM_DIR_LIGHT_SHADOWS )
		directionalLightShadow = directionalLightShadows[ i ];
		directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap[ i ], directionalLightShadow.shadowMapSize, directionalLightShadow.shadowIntensity, directionalLightShadow.shadowBias, directionalLightShadow.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
		#endif
		RE_Direct( directLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if ( NUM_RECT_AREA_LIGHTS > 0 ) && defined( RE_Direct_RectArea )
	RectAreaLight rectAreaLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_RECT_AREA_LIGHTS; i ++ ) {
		rectAreaLight = rectAreaLights[ i ];
		RE_Direct_RectArea( rectAreaLight, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
	}
	#pragma unroll_loop_end
#endif
#if defined( RE_IndirectDiffuse )
	vec3 iblIrradiance = vec3( 0.0 );
	vec3 irradiance = getAmbientLightIrradiance( ambientLightColor );
	#if defined( USE_LIGHT_PROBES )
		irradiance += getLightProbeIrradiance( lightProbe, geometryNormal );
	#endif
	#if ( NUM_HEMI_LIGHTS > 0 )
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_HEMI_LIGHTS; i ++ ) {
			irradiance += getHemisphereLightIrradiance( hemisphereLights[ i ], geometryNormal );
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_LIGHT_PROBE_GRIDS > 0
		vec3 probeWorldPos = ( ( vec4( geometryPosition, 1.0 ) - viewMatrix[ 3 ] ) * viewMatrix ).xyz;
		vec3 probeWorldNormal = transformNormalByInverseViewMatrix( geometryNormal, viewMatrix );
		int probeGrid = - 1;
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( isInsideLightProbeGrid( probeWorldPos, probeWorldNormal, probesMin[ i ], probesMax[ i ], probesResolution[ i ] ) ) probeGrid = UNROLLED_LOOP_INDEX;
		}
		#pragma unroll_loop_end
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_LIGHT_PROBE_GRIDS; i ++ ) {
			if ( probeGrid == UNROLLED_LOOP_INDEX ) irradiance += getLightProbeGridIrradiance( probesSH[ i ], probesMin[ i ], probesMax[ i ], probesResolution[ i ], probeWorldPos, probeWorldNormal );
		}
		#pragma unroll_loop_end
	#endif
#endif
#if defined( RE_IndirectSpecular )
	vec3 radiance = vec3( 0.0 );
	vec3 clearcoatRadiance = vec3( 0.0 );
#endif`,d0=`#if defined( RE_IndirectDiffuse )
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		vec3 lightMapIrradiance = lightMapTexel.rgb * lightMapIntensity;
		irradiance += lightMapIrradiance;
	#endif
	#if defined( USE_ENVMAP ) && defined( ENVMAP_TYPE_PMREM )
		#if defined( STANDARD ) || defined( LAMBERT ) || defined( PHONG )
			iblIrradiance += getIBLIrradiance( geometryNormal );
		#endif
	#endif
#endif
#if defined( USE_ENVMAP ) && defined( RE_IndirectSpecular )
	#ifdef USE_ANISOTROPY
		vec3 iblRadiance = getIBLAnisotropyRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
	#else
		vec3 iblRadiance = getIBLRadiance( geometryViewDir, geometryNormal, material.roughness );
	#endif
	#ifdef USE_RETROREFLECTION
		#ifdef USE_ANISOTROPY
			vec3 retroIBLRadiance = getIBLAnisotropyRetroRadiance( geometryViewDir, geometryNormal, material.roughness, material.anisotropyB, material.anisotropy );
		#else
			vec3 retroIBLRadiance = getIBLRetroRadiance( geometryViewDir, geometryNormal, material.roughness );
		#endif
		iblRadiance = mix( iblRadiance, retroIBLRadiance, saturate( material.retroreflectivity ) );
	#endif
	radiance += iblRadiance;
	#ifdef USE_CLEARCOAT
		clearcoatRadiance += getIBLRadiance( geometryViewDir, geometryClearcoatNormal, material.clearcoatRoughness );
	#endif
#endif`,p0=`#if defined( RE_IndirectDiffuse )
	#if defined( LAMBERT ) || defined( PHONG )
		irradiance += iblIrradiance;
	#endif
	RE_IndirectDiffuse( irradiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif
#if defined( RE_IndirectSpecular )
	RE_IndirectSpecular( radiance, iblIrradiance, clearcoatRadiance, geometryPosition, geometryNormal, geometryViewDir, geometryClearcoatNormal, material, reflectedLight );
#endif`,m0=`#if NUM_LIGHT_PROBE_GRIDS > 0
uniform highp sampler3D probesSH[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMin[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesMax[ NUM_LIGHT_PROBE_GRIDS ];
uniform vec3 probesResolution[ NUM_LIGHT_PROBE_GRIDS ];
bool isInsideLightProbeGrid( vec3 worldPos, vec3 worldNormal, vec3 probesMin, vec3 probesMax, vec3 probesResolution ) {
	vec3 spacing = ( probesMax - probesMin ) / probesResolution;
	vec3 samplePos = worldPos + worldNormal * spacing * 0.5;
	vec3 margin = spacing * 0.01;
	return all( greaterThanEqual( samplePos, probesMin - margin ) ) && all( lessThanEqual( samplePos, probesMax + margin ) );
}
vec3 getLightProbeGridIrradiance( highp sampler3D probesSH, vec3 probesMin, vec3 probesMax, vec3 probesResolution, vec3 worldPos, vec3 worldNormal ) {
	vec3 res = probesResolution;
	vec3 gridRange = probesMax - probesMin;
	vec3 probeSpacing = gridRange / res;
	vec3 samplePos = worldPos + worldNormal * probeSpacing * 0.5;
	vec3 uvw = clamp( ( samplePos - probesMin ) / gridRange, 0.5 / res, 1.0 - 0.5 / res );
	float nz          = res.z;
	float paddedSlices = nz + 2.0;
	float atlasDepth  = 7.0 * paddedSlices;
	float uvZBase     = uvw.z * nz + 1.0;
	vec4 s0 = texture( probesSH, vec3( uvw.xy, ( uvZBase                       ) / atlasDepth ) );
	vec4 s1 = texture( probesSH, vec3( uvw.xy, ( uvZBase +       paddedSlices   ) / atlasDepth ) );
	vec4 s2 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 2.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s3 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 3.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s4 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 4.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s5 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 5.0 * paddedSlices   ) / atlasDepth ) );
	vec4 s6 = texture( probesSH, vec3( uvw.xy, ( uvZBase + 6.0 * paddedSlices   ) / atlasDepth ) );
	vec3 c0 = s0.xyz;
	vec3 c1 = vec3( s0.w, s1.xy );
	vec3 c2 = vec3( s1.zw, s2.x );
	vec3 c3 = s2.yzw;
	vec3 c4 = s3.xyz;
	vec3 c5 = vec3( s3.w, s4.xy );
	vec3 c6 = vec3( s4.zw, s5.x );
	vec3 c7 = s5.yzw;
	vec3 c8 = s6.xyz;
	float x = worldNormal.x, y = worldNormal.y, z = worldNormal.z;
	vec3 result = c0 * 0.886227;
	result += c1 * 2.0 * 0.511664 * y;
	result += c2 * 2.0 * 0.511664 * z;
	result += c3 * 2.0 * 0.511664 * x;
	result += c4 * 2.0 * 0.429043 * x * y;
	result += c5 * 2.0 * 0.429043 * y * z;
	result += c6 * ( 0.743125 * z * z - 0.247708 );
	result += c7 * 2.0 * 0.429043 * x * z;
	result += c8 * 0.429043 * ( x * x - y * y );
	return max( result, vec3( 0.0 ) );
}
#endif`,g0=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	gl_FragDepth = vIsPerspective == 0.0 ? gl_FragCoord.z : log2( vFragDepth ) * logDepthBufFC * 0.5;
#endif`,_0=`#if defined( USE_LOGARITHMIC_DEPTH_BUFFER )
	uniform float logDepthBufFC;
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,x0=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	varying float vFragDepth;
	varying float vIsPerspective;
#endif`,v0=`#ifdef USE_LOGARITHMIC_DEPTH_BUFFER
	vFragDepth = 1.0 + gl_Position.w;
	vIsPerspective = float( isPerspectiveMatrix( projectionMatrix ) );
#endif`,y0=`#ifdef USE_MAP
	vec4 sampledDiffuseColor = texture2D( map, vMapUv );
	#ifdef DECODE_VIDEO_TEXTURE
		sampledDiffuseColor = sRGBTransferEOTF( sampledDiffuseColor );
	#endif
	diffuseColor *= sampledDiffuseColor;
#endif`,S0=`#ifdef USE_MAP
	uniform sampler2D map;
#endif`,M0=`#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
	#if defined( USE_POINTS_UV )
		vec2 uv = vUv;
	#else
		vec2 uv = ( uvTransform * vec3( gl_PointCoord.x, 1.0 - gl_PointCoord.y, 1 ) ).xy;
	#endif
#endif
#ifdef USE_MAP
	diffuseColor *= texture2D( map, uv );
#endif
#ifdef USE_ALPHAMAP
	diffuseColor.a *= texture2D( alphaMap, uv ).g;
#endif`,b0=`#if defined( USE_POINTS_UV )
	varying vec2 vUv;
#else
	#if defined( USE_MAP ) || defined( USE_ALPHAMAP )
		uniform mat3 uvTransform;
	#endif
#endif
#ifdef USE_MAP
	uniform sampler2D map;
#endif
#ifdef USE_ALPHAMAP
	uniform sampler2D alphaMap;
#endif`,w0=`float metalnessFactor = metalness;
#ifdef USE_METALNESSMAP
	vec4 texelMetalness = texture2D( metalnessMap, vMetalnessMapUv );
	metalnessFactor *= texelMetalness.b;
#endif`,E0=`#ifdef USE_METALNESSMAP
	uniform sampler2D metalnessMap;
#endif`,A0=`#ifdef USE_INSTANCING_MORPH
	float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	float morphTargetBaseInfluence = texelFetch( morphTexture, ivec2( 0, gl_InstanceID ), 0 ).r;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		morphTargetInfluences[i] =  texelFetch( morphTexture, ivec2( i + 1, gl_InstanceID ), 0 ).r;
	}
#endif`,T0=`#if defined( USE_MORPHCOLORS )
	#if defined( USE_COLOR_ALPHA )
		vColor *= morphTargetBaseInfluence;
	#elif defined( USE_COLOR )
		vColor.rgb *= morphTargetBaseInfluence;
	#endif
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		#if defined( USE_COLOR_ALPHA )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor += getMorph( gl_VertexID, i, 2 ) * morphTargetInfluences[ i ];
		#elif defined( USE_COLOR )
			if ( morphTargetInfluences[ i ] != 0.0 ) vColor.rgb += getMorph( gl_VertexID, i, 2 ).rgb * morphTargetInfluences[ i ];
		#endif
	}
#endif`,R0=`#ifdef USE_MORPHNORMALS
	objectNormal *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) objectNormal += getMorph( gl_VertexID, i, 1 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,C0=`#ifdef USE_MORPHTARGETS
	#ifndef USE_INSTANCING_MORPH
		uniform float morphTargetBaseInfluence;
		uniform float morphTargetInfluences[ MORPHTARGETS_COUNT ];
	#endif
	uniform sampler2DArray morphTargetsTexture;
	uniform ivec2 morphTargetsTextureSize;
	vec4 getMorph( const in int vertexIndex, const in int morphTargetIndex, const in int offset ) {
		int texelIndex = vertexIndex * MORPHTARGETS_TEXTURE_STRIDE + offset;
		int y = texelIndex / morphTargetsTextureSize.x;
		int x = texelIndex - y * morphTargetsTextureSize.x;
		ivec3 morphUV = ivec3( x, y, morphTargetIndex );
		return texelFetch( morphTargetsTexture, morphUV, 0 );
	}
#endif`,I0=`#ifdef USE_MORPHTARGETS
	transformed *= morphTargetBaseInfluence;
	for ( int i = 0; i < MORPHTARGETS_COUNT; i ++ ) {
		if ( morphTargetInfluences[ i ] != 0.0 ) transformed += getMorph( gl_VertexID, i, 0 ).xyz * morphTargetInfluences[ i ];
	}
#endif`,P0=`float faceDirection = gl_FrontFacing ? 1.0 : - 1.0;
#ifdef FLAT_SHADED
	vec3 fdx = dFdx( vViewPosition );
	vec3 fdy = dFdy( vViewPosition );
	vec3 normal = normalize( cross( fdx, fdy ) );
#else
	vec3 normal = normalize( vNormal );
	#ifdef DOUBLE_SIDED
		normal *= faceDirection;
	#endif
#endif
#if defined( USE_NORMALMAP_TANGENTSPACE ) || defined( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY )
	#ifdef USE_TANGENT
		mat3 tbn = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn = getTangentFrame( - vViewPosition, normal,
		#if defined( USE_NORMALMAP )
			vNormalMapUv
		#elif defined( USE_CLEARCOAT_NORMALMAP )
			vClearcoatNormalMapUv
		#else
			vUv
		#endif
		);
	#endif
	#ifdef DOUBLE_SIDED
		tbn[0] *= faceDirection;
		tbn[1] *= faceDirection;
	#endif
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	#ifdef USE_TANGENT
		mat3 tbn2 = mat3( normalize( vTangent ), normalize( vBitangent ), normal );
	#else
		mat3 tbn2 = getTangentFrame( - vViewPosition, normal, vClearcoatNormalMapUv );
	#endif
	#ifdef DOUBLE_SIDED
		tbn2[0] *= faceDirection;
		tbn2[1] *= faceDirection;
	#endif
#endif
vec3 nonPerturbedNormal = normal;`,N0=`#ifdef USE_NORMALMAP_OBJECTSPACE
	normal = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#ifdef FLIP_SIDED
		normal = - normal;
	#endif
	#ifdef DOUBLE_SIDED
		normal = normal * faceDirection;
	#endif
	normal = normalize( normalMatrix * normal );
#elif defined( USE_NORMALMAP_TANGENTSPACE )
	vec3 mapN = texture2D( normalMap, vNormalMapUv ).xyz * 2.0 - 1.0;
	#if defined( USE_PACKED_NORMALMAP )
		mapN = vec3( mapN.xy, sqrt( saturate( 1.0 - dot( mapN.xy, mapN.xy ) ) ) );
	#endif
	mapN.xy *= normalScale;
	normal = normalize( tbn * mapN );
#elif defined( USE_BUMPMAP )
	normal = perturbNormalArb( - vViewPosition, normal, dHdxy_fwd(), faceDirection );
#endif`,L0=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,D0=`#ifndef FLAT_SHADED
	varying vec3 vNormal;
	#ifdef USE_TANGENT
		varying vec3 vTangent;
		varying vec3 vBitangent;
	#endif
#endif`,U0=`#ifndef FLAT_SHADED
	vNormal = normalize( transformedNormal );
	#ifdef USE_TANGENT
		vTangent = normalize( transformedTangent );
		vBitangent = normalize( cross( vNormal, vTangent ) * tangent.w );
		#ifdef FLIP_SIDED
			vBitangent = - vBitangent;
		#endif
	#endif
#endif`,F0=`#ifdef USE_NORMALMAP
	uniform sampler2D normalMap;
	uniform vec2 normalScale;
#endif
#ifdef USE_NORMALMAP_OBJECTSPACE
	uniform mat3 normalMatrix;
#endif
#if ! defined ( USE_TANGENT ) && ( defined ( USE_NORMALMAP_TANGENTSPACE ) || defined ( USE_CLEARCOAT_NORMALMAP ) || defined( USE_ANISOTROPY ) )
	mat3 getTangentFrame( vec3 eye_pos, vec3 surf_norm, vec2 uv ) {
		vec3 q0 = dFdx( eye_pos.xyz );
		vec3 q1 = dFdy( eye_pos.xyz );
		vec2 st0 = dFdx( uv.st );
		vec2 st1 = dFdy( uv.st );
		vec3 N = surf_norm;
		vec3 q1perp = cross( q1, N );
		vec3 q0perp = cross( N, q0 );
		vec3 T = q1perp * st0.x + q0perp * st1.x;
		vec3 B = q1perp * st0.y + q0perp * st1.y;
		float det = max( dot( T, T ), dot( B, B ) );
		float scale = ( det == 0.0 ) ? 0.0 : inversesqrt( det );
		return mat3( T * scale, B * scale, N );
	}
#endif`,O0=`#ifdef USE_CLEARCOAT
	vec3 clearcoatNormal = nonPerturbedNormal;
#endif`,B0=`#ifdef USE_CLEARCOAT_NORMALMAP
	vec3 clearcoatMapN = texture2D( clearcoatNormalMap, vClearcoatNormalMapUv ).xyz * 2.0 - 1.0;
	clearcoatMapN.xy *= clearcoatNormalScale;
	clearcoatNormal = normalize( tbn2 * clearcoatMapN );
#endif`,z0=`#ifdef USE_CLEARCOATMAP
	uniform sampler2D clearcoatMap;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform sampler2D clearcoatNormalMap;
	uniform vec2 clearcoatNormalScale;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform sampler2D clearcoatRoughnessMap;
#endif`,k0=`#ifdef USE_IRIDESCENCEMAP
	uniform sampler2D iridescenceMap;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform sampler2D iridescenceThicknessMap;
#endif`,G0=`#ifdef OPAQUE
diffuseColor.a = 1.0;
#endif
#ifdef USE_TRANSMISSION
diffuseColor.a *= material.transmissionAlpha;
#endif
gl_FragColor = vec4( outgoingLight, diffuseColor.a );`,V0=`vec3 packNormalToRGB( const in vec3 normal ) {
	return normalize( normal ) * 0.5 + 0.5;
}
vec3 unpackRGBToNormal( const in vec3 rgb ) {
	return 2.0 * rgb.xyz - 1.0;
}
const float PackUpscale = 256. / 255.;const float UnpackDownscale = 255. / 256.;const float ShiftRight8 = 1. / 256.;
const float Inv255 = 1. / 255.;
const vec4 PackFactors = vec4( 1.0, 256.0, 256.0 * 256.0, 256.0 * 256.0 * 256.0 );
const vec2 UnpackFactors2 = vec2( UnpackDownscale, 1.0 / PackFactors.g );
const vec3 UnpackFactors3 = vec3( UnpackDownscale / PackFactors.rg, 1.0 / PackFactors.b );
const vec4 UnpackFactors4 = vec4( UnpackDownscale / PackFactors.rgb, 1.0 / PackFactors.a );
vec4 packDepthToRGBA( const in float v ) {
	if( v <= 0.0 )
		return vec4( 0., 0., 0., 0. );
	if( v >= 1.0 )
		return vec4( 1., 1., 1., 1. );
	float vuf;
	float af = modf( v * PackFactors.a, vuf );
	float bf = modf( vuf * ShiftRight8, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec4( vuf * Inv255, gf * PackUpscale, bf * PackUpscale, af );
}
vec3 packDepthToRGB( const in float v ) {
	if( v <= 0.0 )
		return vec3( 0., 0., 0. );
	if( v >= 1.0 )
		return vec3( 1., 1., 1. );
	float vuf;
	float bf = modf( v * PackFactors.b, vuf );
	float gf = modf( vuf * ShiftRight8, vuf );
	return vec3( vuf * Inv255, gf * PackUpscale, bf );
}
vec2 packDepthToRG( const in float v ) {
	if( v <= 0.0 )
		return vec2( 0., 0. );
	if( v >= 1.0 )
		return vec2( 1., 1. );
	float vuf;
	float gf = modf( v * 256., vuf );
	return vec2( vuf * Inv255, gf );
}
float unpackRGBAToDepth( const in vec4 v ) {
	return dot( v, UnpackFactors4 );
}
float unpackRGBToDepth( const in vec3 v ) {
	return dot( v, UnpackFactors3 );
}
float unpackRGToDepth( const in vec2 v ) {
	return v.r * UnpackFactors2.r + v.g * UnpackFactors2.g;
}
vec4 pack2HalfToRGBA( const in vec2 v ) {
	vec4 r = vec4( v.x, fract( v.x * 255.0 ), v.y, fract( v.y * 255.0 ) );
	return vec4( r.x - r.y / 255.0, r.y, r.z - r.w / 255.0, r.w );
}
vec2 unpackRGBATo2Half( const in vec4 v ) {
	return vec2( v.x + ( v.y / 255.0 ), v.z + ( v.w / 255.0 ) );
}
float viewZToOrthographicDepth( const in float viewZ, const in float near, const in float far ) {
	return ( viewZ + near ) / ( near - far );
}
float orthographicDepthToViewZ( const in float depth, const in float near, const in float far ) {
	#ifdef USE_REVERSED_DEPTH_BUFFER
	
		return depth * ( far - near ) - far;
	#else
		return depth * ( near - far ) - near;
	#endif
}
float viewZToPerspectiveDepth( const in float viewZ, const in float near, const in float far ) {
	return ( ( near + viewZ ) * far ) / ( ( far - near ) * viewZ );
}
float perspectiveDepthToViewZ( const in float depth, const in float near, const in float far ) {
	
	#ifdef USE_REVERSED_DEPTH_BUFFER
		return ( near * far ) / ( ( near - far ) * depth - near );
	#else
		return ( near * far ) / ( ( far - near ) * depth - far );
	#endif
}`,H0=`#ifdef PREMULTIPLIED_ALPHA
	gl_FragColor.rgb *= gl_FragColor.a;
#endif`,W0=`vec4 mvPosition = vec4( transformed, 1.0 );
#ifdef USE_BATCHING
	mvPosition = batchingMatrix * mvPosition;
#endif
#ifdef USE_INSTANCING
	mvPosition = instanceMatrix * mvPosition;
#endif
mvPosition = modelViewMatrix * mvPosition;
gl_Position = projectionMatrix * mvPosition;`,X0=`#ifdef DITHERING
	gl_FragColor.rgb = dithering( gl_FragColor.rgb );
#endif`,q0=`#ifdef DITHERING
	vec3 dithering( vec3 color ) {
		float grid_position = rand( gl_FragCoord.xy );
		vec3 dither_shift_RGB = vec3( 0.25 / 255.0, -0.25 / 255.0, 0.25 / 255.0 );
		dither_shift_RGB = mix( 2.0 * dither_shift_RGB, -2.0 * dither_shift_RGB, grid_position );
		return color + dither_shift_RGB;
	}
#endif`,Y0=`float roughnessFactor = roughness;
#ifdef USE_ROUGHNESSMAP
	vec4 texelRoughness = texture2D( roughnessMap, vRoughnessMapUv );
	roughnessFactor *= texelRoughness.g;
#endif`,Z0=`#ifdef USE_ROUGHNESSMAP
	uniform sampler2D roughnessMap;
#endif`,J0=`#if NUM_SPOT_LIGHT_COORDS > 0
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#if NUM_SPOT_LIGHT_MAPS > 0
	uniform sampler2D spotLightMap[ NUM_SPOT_LIGHT_MAPS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		#define SUN_LIGHT_CASCADES 2
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#else
			uniform sampler2D sunShadowMap[ NUM_SUN_LIGHT_SHADOWS ];
		#endif
		uniform mat4 sunShadowMatrix[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		uniform vec4 sunShadowCascade[ NUM_SUN_LIGHT_SHADOWS * SUN_LIGHT_CASCADES ];
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
		struct SunLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SunLightShadow sunLightShadows[ NUM_SUN_LIGHT_SHADOWS ];
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#else
			uniform sampler2D directionalShadowMap[ NUM_DIR_LIGHT_SHADOWS ];
		#endif
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform sampler2DShadow spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#else
			uniform sampler2D spotShadowMap[ NUM_SPOT_LIGHT_SHADOWS ];
		#endif
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#if defined( SHADOWMAP_TYPE_PCF )
			uniform samplerCubeShadow pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#elif defined( SHADOWMAP_TYPE_BASIC )
			uniform samplerCube pointShadowMap[ NUM_POINT_LIGHT_SHADOWS ];
		#endif
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float interleavedGradientNoise( vec2 position ) {
			return fract( 52.9829189 * fract( dot( position, vec2( 0.06711056, 0.00583715 ) ) ) );
		}
		vec2 vogelDiskSample( int sampleIndex, int samplesCount, float phi ) {
			const float goldenAngle = 2.399963229728653;
			float r = sqrt( ( float( sampleIndex ) + 0.5 ) / float( samplesCount ) );
			float theta = float( sampleIndex ) * goldenAngle + phi;
			return vec2( cos( theta ), sin( theta ) ) * r;
		}
	#endif
	#if defined( SHADOWMAP_TYPE_PCF )
		float getShadow( sampler2DShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 texelSize = vec2( 1.0 ) / shadowMapSize;
				vec2 radius = shadowRadius * texelSize;
				float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
				shadow = (
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 0, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 1, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 2, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 3, 5, phi ) * radius, shadowCoord.z ) ) +
					texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( 4, 5, phi ) * radius, shadowCoord.z ) )
				) * 0.2;
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#elif defined( SHADOWMAP_TYPE_VSM )
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				vec2 distribution = texture2D( shadowMap, shadowCoord.xy ).rg;
				float mean = distribution.x;
				float variance = distribution.y * distribution.y;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					float hard_shadow = step( mean, shadowCoord.z );
				#else
					float hard_shadow = step( shadowCoord.z, mean );
				#endif
				
				if ( hard_shadow == 1.0 ) {
					shadow = 1.0;
				} else {
					variance = max( variance, 0.0000001 );
					float d = shadowCoord.z - mean;
					float p_max = variance / ( variance + d * d );
					p_max = clamp( ( p_max - 0.3 ) / 0.65, 0.0, 1.0 );
					shadow = max( hard_shadow, p_max );
				}
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#else
		float getShadow( sampler2D shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord ) {
			float shadow = 1.0;
			shadowCoord.xyz /= shadowCoord.w;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				shadowCoord.z -= shadowBias;
			#else
				shadowCoord.z += shadowBias;
			#endif
			bool inFrustum = shadowCoord.x >= 0.0 && shadowCoord.x <= 1.0 && shadowCoord.y >= 0.0 && shadowCoord.y <= 1.0;
			bool frustumTest = inFrustum && shadowCoord.z <= 1.0;
			if ( frustumTest ) {
				float depth = texture2D( shadowMap, shadowCoord.xy ).r;
				#ifdef USE_REVERSED_DEPTH_BUFFER
					shadow = step( depth, shadowCoord.z );
				#else
					shadow = step( shadowCoord.z, depth );
				#endif
			}
			return mix( 1.0, shadow, shadowIntensity );
		}
	#endif
	#if NUM_SUN_LIGHT_SHADOWS > 0
		float getSunShadow(
			#if defined( SHADOWMAP_TYPE_PCF )
				sampler2DShadow shadowMap,
			#else
				sampler2D shadowMap,
			#endif
			SunLightShadow sunLightShadow,
			int shadowIndex
		) {
			vec4 shadowWorldPosition = vec4( vSunShadowWorldPosition.xyz + vSunShadowWorldNormal * sunLightShadow.shadowNormalBias, 1.0 );
			float viewDepth = vSunShadowWorldPosition.w;
			int cascadeOffset = shadowIndex * SUN_LIGHT_CASCADES;
			float shadow = 1.0;
			for ( int i = SUN_LIGHT_CASCADES - 1; i >= 0; i -- ) {
				vec4 cascade = sunShadowCascade[ cascadeOffset + i ];
				if ( viewDepth >= cascade.x && viewDepth < cascade.y ) {
					float cascadeShadow = getShadow(
						shadowMap,
						sunLightShadow.shadowMapSize,
						sunLightShadow.shadowIntensity,
						sunLightShadow.shadowBias,
						sunLightShadow.shadowRadius,
						sunShadowMatrix[ cascadeOffset + i ] * shadowWorldPosition
					);
					shadow = mix( cascadeShadow, shadow, smoothstep( cascade.z, cascade.y, viewDepth ) );
				}
			}
			return shadow;
		}
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
	#if defined( SHADOWMAP_TYPE_PCF )
	float getPointShadow( samplerCubeShadow shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 bd3D = normalize( lightToPosition );
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float lightDistance = length( lightToPosition );
			float depthRange = shadowCameraFar - shadowCameraNear;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				float depthA = - shadowCameraNear / depthRange - shadowBias;
				float depthB = shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#else
				float depthA = shadowCameraFar / depthRange + shadowBias;
				float depthB = - shadowCameraNear * shadowCameraFar / ( depthRange * lightDistance );
			#endif
			float texelSize = shadowRadius / shadowMapSize.x;
			vec3 absDir = abs( bd3D );
			vec3 tangent = absDir.x > absDir.z ? vec3( 0.0, 1.0, 0.0 ) : vec3( 1.0, 0.0, 0.0 );
			tangent = normalize( cross( bd3D, tangent ) );
			vec3 bitangent = cross( bd3D, tangent );
			float phi = interleavedGradientNoise( gl_FragCoord.xy ) * PI2;
			shadow = 0.0;
			for ( int i = 0; i < 5; i ++ ) {
				vec2 offset = vogelDiskSample( i, 5, phi );
				vec3 direction = bd3D + ( tangent * offset.x + bitangent * offset.y ) * texelSize;
				vec3 absDirection = abs( direction );
				float dp = depthA + depthB / max( max( absDirection.x, absDirection.y ), absDirection.z );
				shadow += texture( shadowMap, vec4( direction, dp ) );
			}
			shadow *= 0.2;
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#elif defined( SHADOWMAP_TYPE_BASIC )
	float getPointShadow( samplerCube shadowMap, vec2 shadowMapSize, float shadowIntensity, float shadowBias, float shadowRadius, vec4 shadowCoord, float shadowCameraNear, float shadowCameraFar ) {
		float shadow = 1.0;
		vec3 lightToPosition = shadowCoord.xyz;
		vec3 absVec = abs( lightToPosition );
		float viewSpaceZ = max( max( absVec.x, absVec.y ), absVec.z );
		if ( viewSpaceZ - shadowCameraFar <= 0.0 && viewSpaceZ - shadowCameraNear >= 0.0 ) {
			float dp = ( shadowCameraFar * ( viewSpaceZ - shadowCameraNear ) ) / ( viewSpaceZ * ( shadowCameraFar - shadowCameraNear ) );
			dp += shadowBias;
			vec3 bd3D = normalize( lightToPosition );
			float depth = textureCube( shadowMap, bd3D ).r;
			#ifdef USE_REVERSED_DEPTH_BUFFER
				depth = 1.0 - depth;
			#endif
			shadow = step( dp, depth );
		}
		return mix( 1.0, shadow, shadowIntensity );
	}
	#endif
	#endif
#endif`,$0=`#if NUM_SPOT_LIGHT_COORDS > 0
	uniform mat4 spotLightMatrix[ NUM_SPOT_LIGHT_COORDS ];
	varying vec4 vSpotLightCoord[ NUM_SPOT_LIGHT_COORDS ];
#endif
#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
		varying vec4 vSunShadowWorldPosition;
		varying vec3 vSunShadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		uniform mat4 directionalShadowMatrix[ NUM_DIR_LIGHT_SHADOWS ];
		varying vec4 vDirectionalShadowCoord[ NUM_DIR_LIGHT_SHADOWS ];
		struct DirectionalLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform DirectionalLightShadow directionalLightShadows[ NUM_DIR_LIGHT_SHADOWS ];
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
		struct SpotLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
		};
		uniform SpotLightShadow spotLightShadows[ NUM_SPOT_LIGHT_SHADOWS ];
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		uniform mat4 pointShadowMatrix[ NUM_POINT_LIGHT_SHADOWS ];
		varying vec4 vPointShadowCoord[ NUM_POINT_LIGHT_SHADOWS ];
		struct PointLightShadow {
			float shadowIntensity;
			float shadowBias;
			float shadowNormalBias;
			float shadowRadius;
			vec2 shadowMapSize;
			float shadowCameraNear;
			float shadowCameraFar;
		};
		uniform PointLightShadow pointLightShadows[ NUM_POINT_LIGHT_SHADOWS ];
	#endif
#endif`,K0=`#if ( defined( USE_SHADOWMAP ) && ( NUM_DIR_LIGHT_SHADOWS > 0 || NUM_SUN_LIGHT_SHADOWS > 0 || NUM_POINT_LIGHT_SHADOWS > 0 ) ) || ( NUM_SPOT_LIGHT_COORDS > 0 )
	#ifdef HAS_NORMAL
		vec3 shadowWorldNormal = transformNormalByInverseViewMatrix( transformedNormal, viewMatrix );
	#else
		vec3 shadowWorldNormal = vec3( 0.0 );
	#endif
	vec4 shadowWorldPosition;
#endif
#if defined( USE_SHADOWMAP )
	#if NUM_SUN_LIGHT_SHADOWS > 0
		vSunShadowWorldPosition = vec4( worldPosition.xyz, - mvPosition.z );
		vSunShadowWorldNormal = shadowWorldNormal;
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * directionalLightShadows[ i ].shadowNormalBias, 0 );
			vDirectionalShadowCoord[ i ] = directionalShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0
		#pragma unroll_loop_start
		for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
			shadowWorldPosition = worldPosition + vec4( shadowWorldNormal * pointLightShadows[ i ].shadowNormalBias, 0 );
			vPointShadowCoord[ i ] = pointShadowMatrix[ i ] * shadowWorldPosition;
		}
		#pragma unroll_loop_end
	#endif
#endif
#if NUM_SPOT_LIGHT_COORDS > 0
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_COORDS; i ++ ) {
		shadowWorldPosition = worldPosition;
		#if ( defined( USE_SHADOWMAP ) && UNROLLED_LOOP_INDEX < NUM_SPOT_LIGHT_SHADOWS )
			shadowWorldPosition.xyz += shadowWorldNormal * spotLightShadows[ i ].shadowNormalBias;
		#endif
		vSpotLightCoord[ i ] = spotLightMatrix[ i ] * shadowWorldPosition;
	}
	#pragma unroll_loop_end
#endif`,Q0=`float getShadowMask() {
	float shadow = 1.0;
	#ifdef USE_SHADOWMAP
	#if NUM_SUN_LIGHT_SHADOWS > 0
	SunLightShadow sunLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SUN_LIGHT_SHADOWS; i ++ ) {
		sunLight = sunLightShadows[ i ];
		shadow *= receiveShadow ? getSunShadow( sunShadowMap[ i ], sunLight, UNROLLED_LOOP_INDEX ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_DIR_LIGHT_SHADOWS > 0
	DirectionalLightShadow directionalLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_DIR_LIGHT_SHADOWS; i ++ ) {
		directionalLight = directionalLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( directionalShadowMap[ i ], directionalLight.shadowMapSize, directionalLight.shadowIntensity, directionalLight.shadowBias, directionalLight.shadowRadius, vDirectionalShadowCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_SPOT_LIGHT_SHADOWS > 0
	SpotLightShadow spotLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_SPOT_LIGHT_SHADOWS; i ++ ) {
		spotLight = spotLightShadows[ i ];
		shadow *= receiveShadow ? getShadow( spotShadowMap[ i ], spotLight.shadowMapSize, spotLight.shadowIntensity, spotLight.shadowBias, spotLight.shadowRadius, vSpotLightCoord[ i ] ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#if NUM_POINT_LIGHT_SHADOWS > 0 && ( defined( SHADOWMAP_TYPE_PCF ) || defined( SHADOWMAP_TYPE_BASIC ) )
	PointLightShadow pointLight;
	#pragma unroll_loop_start
	for ( int i = 0; i < NUM_POINT_LIGHT_SHADOWS; i ++ ) {
		pointLight = pointLightShadows[ i ];
		shadow *= receiveShadow ? getPointShadow( pointShadowMap[ i ], pointLight.shadowMapSize, pointLight.shadowIntensity, pointLight.shadowBias, pointLight.shadowRadius, vPointShadowCoord[ i ], pointLight.shadowCameraNear, pointLight.shadowCameraFar ) : 1.0;
	}
	#pragma unroll_loop_end
	#endif
	#endif
	return shadow;
}`,j0=`#ifdef USE_SKINNING
	mat4 boneMatX = getBoneMatrix( skinIndex.x );
	mat4 boneMatY = getBoneMatrix( skinIndex.y );
	mat4 boneMatZ = getBoneMatrix( skinIndex.z );
	mat4 boneMatW = getBoneMatrix( skinIndex.w );
#endif`,t_=`#ifdef USE_SKINNING
	uniform mat4 bindMatrix;
	uniform mat4 bindMatrixInverse;
	uniform highp sampler2D boneTexture;
	mat4 getBoneMatrix( const in float i ) {
		int size = textureSize( boneTexture, 0 ).x;
		int j = int( i ) * 4;
		int x = j % size;
		int y = j / size;
		vec4 v1 = texelFetch( boneTexture, ivec2( x, y ), 0 );
		vec4 v2 = texelFetch( boneTexture, ivec2( x + 1, y ), 0 );
		vec4 v3 = texelFetch( boneTexture, ivec2( x + 2, y ), 0 );
		vec4 v4 = texelFetch( boneTexture, ivec2( x + 3, y ), 0 );
		return mat4( v1, v2, v3, v4 );
	}
#endif`,e_=`#ifdef USE_SKINNING
	vec4 skinVertex = bindMatrix * vec4( transformed, 1.0 );
	vec4 skinned = vec4( 0.0 );
	skinned += boneMatX * skinVertex * skinWeight.x;
	skinned += boneMatY * skinVertex * skinWeight.y;
	skinned += boneMatZ * skinVertex * skinWeight.z;
	skinned += boneMatW * skinVertex * skinWeight.w;
	transformed = ( bindMatrixInverse * skinned ).xyz;
#endif`,n_=`#ifdef USE_SKINNING
	mat4 skinMatrix = mat4( 0.0 );
	skinMatrix += skinWeight.x * boneMatX;
	skinMatrix += skinWeight.y * boneMatY;
	skinMatrix += skinWeight.z * boneMatZ;
	skinMatrix += skinWeight.w * boneMatW;
	skinMatrix = bindMatrixInverse * skinMatrix * bindMatrix;
	objectNormal = vec4( skinMatrix * vec4( objectNormal, 0.0 ) ).xyz;
	#ifdef USE_TANGENT
		objectTangent = vec4( skinMatrix * vec4( objectTangent, 0.0 ) ).xyz;
	#endif
#endif`,i_=`float specularStrength;
#ifdef USE_SPECULARMAP
	vec4 texelSpecular = texture2D( specularMap, vSpecularMapUv );
	specularStrength = texelSpecular.r;
#else
	specularStrength = 1.0;
#endif`,r_=`#ifdef USE_SPECULARMAP
	uniform sampler2D specularMap;
#endif`,s_=`#if defined( TONE_MAPPING )
	gl_FragColor.rgb = toneMapping( gl_FragColor.rgb );
#endif`,a_=`#ifndef saturate
#define saturate( a ) clamp( a, 0.0, 1.0 )
#endif
uniform float toneMappingExposure;
vec3 LinearToneMapping( vec3 color ) {
	return saturate( toneMappingExposure * color );
}
vec3 ReinhardToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	return saturate( color / ( vec3( 1.0 ) + color ) );
}
vec3 CineonToneMapping( vec3 color ) {
	color *= toneMappingExposure;
	color = max( vec3( 0.0 ), color - 0.004 );
	return pow( ( color * ( 6.2 * color + 0.5 ) ) / ( color * ( 6.2 * color + 1.7 ) + 0.06 ), vec3( 2.2 ) );
}
vec3 RRTAndODTFit( vec3 v ) {
	vec3 a = v * ( v + 0.0245786 ) - 0.000090537;
	vec3 b = v * ( 0.983729 * v + 0.4329510 ) + 0.238081;
	return a / b;
}
vec3 ACESFilmicToneMapping( vec3 color ) {
	const mat3 ACESInputMat = mat3(
		vec3( 0.59719, 0.07600, 0.02840 ),		vec3( 0.35458, 0.90834, 0.13383 ),
		vec3( 0.04823, 0.01566, 0.83777 )
	);
	const mat3 ACESOutputMat = mat3(
		vec3(  1.60475, -0.10208, -0.00327 ),		vec3( -0.53108,  1.10813, -0.07276 ),
		vec3( -0.07367, -0.00605,  1.07602 )
	);
	color *= toneMappingExposure / 0.6;
	color = ACESInputMat * color;
	color = RRTAndODTFit( color );
	color = ACESOutputMat * color;
	return saturate( color );
}
const mat3 LINEAR_REC2020_TO_LINEAR_SRGB = mat3(
	vec3( 1.6605, - 0.1246, - 0.0182 ),
	vec3( - 0.5876, 1.1329, - 0.1006 ),
	vec3( - 0.0728, - 0.0083, 1.1187 )
);
const mat3 LINEAR_SRGB_TO_LINEAR_REC2020 = mat3(
	vec3( 0.6274, 0.0691, 0.0164 ),
	vec3( 0.3293, 0.9195, 0.0880 ),
	vec3( 0.0433, 0.0113, 0.8956 )
);
vec3 agxDefaultContrastApprox( vec3 x ) {
	vec3 x2 = x * x;
	vec3 x4 = x2 * x2;
	return + 15.5 * x4 * x2
		- 40.14 * x4 * x
		+ 31.96 * x4
		- 6.868 * x2 * x
		+ 0.4298 * x2
		+ 0.1191 * x
		- 0.00232;
}
vec3 AgXToneMapping( vec3 color ) {
	const mat3 AgXInsetMatrix = mat3(
		vec3( 0.856627153315983, 0.137318972929847, 0.11189821299995 ),
		vec3( 0.0951212405381588, 0.761241990602591, 0.0767994186031903 ),
		vec3( 0.0482516061458583, 0.101439036467562, 0.811302368396859 )
	);
	const mat3 AgXOutsetMatrix = mat3(
		vec3( 1.1271005818144368, - 0.1413297634984383, - 0.14132976349843826 ),
		vec3( - 0.11060664309660323, 1.157823702216272, - 0.11060664309660294 ),
		vec3( - 0.016493938717834573, - 0.016493938717834257, 1.2519364065950405 )
	);
	const float AgxMinEv = - 12.47393;	const float AgxMaxEv = 4.026069;
	color *= toneMappingExposure;
	color = LINEAR_SRGB_TO_LINEAR_REC2020 * color;
	color = AgXInsetMatrix * color;
	color = max( color, 1e-10 );	color = log2( color );
	color = ( color - AgxMinEv ) / ( AgxMaxEv - AgxMinEv );
	color = clamp( color, 0.0, 1.0 );
	color = agxDefaultContrastApprox( color );
	color = AgXOutsetMatrix * color;
	color = pow( max( vec3( 0.0 ), color ), vec3( 2.2 ) );
	color = LINEAR_REC2020_TO_LINEAR_SRGB * color;
	color = clamp( color, 0.0, 1.0 );
	return color;
}
vec3 NeutralToneMapping( vec3 color ) {
	const float StartCompression = 0.8 - 0.04;
	const float Desaturation = 0.15;
	color *= toneMappingExposure;
	float x = min( color.r, min( color.g, color.b ) );
	float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
	color -= offset;
	float peak = max( color.r, max( color.g, color.b ) );
	if ( peak < StartCompression ) return color;
	float d = 1. - StartCompression;
	float newPeak = 1. - d * d / ( peak + d - StartCompression );
	color *= newPeak / peak;
	float g = 1. - 1. / ( Desaturation * ( peak - newPeak ) + 1. );
	return mix( color, vec3( newPeak ), g );
}
vec3 CustomToneMapping( vec3 color ) { return color; }`,o_=`#ifdef USE_TRANSMISSION
	material.transmission = transmission;
	material.transmissionAlpha = 1.0;
	material.thickness = thickness;
	material.attenuationDistance = attenuationDistance;
	material.attenuationColor = attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		material.transmission *= texture2D( transmissionMap, vTransmissionMapUv ).r;
	#endif
	#ifdef USE_THICKNESSMAP
		material.thickness *= texture2D( thicknessMap, vThicknessMapUv ).g;
	#endif
	vec3 pos = vWorldPosition;
	vec3 v = normalize( cameraPosition - pos );
	vec3 n = transformNormalByInverseViewMatrix( normal, viewMatrix );
	vec4 transmitted = getIBLVolumeRefraction(
		n, v, material.roughness, material.diffuseContribution, material.specularColorBlended, material.specularF90,
		pos, modelMatrix, viewMatrix, projectionMatrix, material.dispersion, material.ior, material.thickness,
		material.attenuationColor, material.attenuationDistance );
	material.transmissionAlpha = mix( material.transmissionAlpha, transmitted.a, material.transmission );
	totalDiffuse = mix( totalDiffuse, transmitted.rgb, material.transmission );
#endif`,l_=`#ifdef USE_TRANSMISSION
	uniform float transmission;
	uniform float thickness;
	uniform float attenuationDistance;
	uniform vec3 attenuationColor;
	#ifdef USE_TRANSMISSIONMAP
		uniform sampler2D transmissionMap;
	#endif
	#ifdef USE_THICKNESSMAP
		uniform sampler2D thicknessMap;
	#endif
	uniform vec2 transmissionSamplerSize;
	uniform sampler2D transmissionSamplerMap;
	uniform mat4 modelMatrix;
	uniform mat4 projectionMatrix;
	varying vec3 vWorldPosition;
	float w0( float a ) {
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - a + 3.0 ) - 3.0 ) + 1.0 );
	}
	float w1( float a ) {
		return ( 1.0 / 6.0 ) * ( a *  a * ( 3.0 * a - 6.0 ) + 4.0 );
	}
	float w2( float a ){
		return ( 1.0 / 6.0 ) * ( a * ( a * ( - 3.0 * a + 3.0 ) + 3.0 ) + 1.0 );
	}
	float w3( float a ) {
		return ( 1.0 / 6.0 ) * ( a * a * a );
	}
	float g0( float a ) {
		return w0( a ) + w1( a );
	}
	float g1( float a ) {
		return w2( a ) + w3( a );
	}
	float h0( float a ) {
		return - 1.0 + w1( a ) / ( w0( a ) + w1( a ) );
	}
	float h1( float a ) {
		return 1.0 + w3( a ) / ( w2( a ) + w3( a ) );
	}
	vec4 bicubic( sampler2D tex, vec2 uv, vec4 texelSize, float lod ) {
		uv = uv * texelSize.zw + 0.5;
		vec2 iuv = floor( uv );
		vec2 fuv = fract( uv );
		float g0x = g0( fuv.x );
		float g1x = g1( fuv.x );
		float h0x = h0( fuv.x );
		float h1x = h1( fuv.x );
		float h0y = h0( fuv.y );
		float h1y = h1( fuv.y );
		vec2 p0 = ( vec2( iuv.x + h0x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p1 = ( vec2( iuv.x + h1x, iuv.y + h0y ) - 0.5 ) * texelSize.xy;
		vec2 p2 = ( vec2( iuv.x + h0x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		vec2 p3 = ( vec2( iuv.x + h1x, iuv.y + h1y ) - 0.5 ) * texelSize.xy;
		return g0( fuv.y ) * ( g0x * textureLod( tex, p0, lod ) + g1x * textureLod( tex, p1, lod ) ) +
			g1( fuv.y ) * ( g0x * textureLod( tex, p2, lod ) + g1x * textureLod( tex, p3, lod ) );
	}
	vec4 textureBicubic( sampler2D sampler, vec2 uv, float lod ) {
		vec2 fLodSize = vec2( textureSize( sampler, int( lod ) ) );
		vec2 cLodSize = vec2( textureSize( sampler, int( lod + 1.0 ) ) );
		vec2 fLodSizeInv = 1.0 / fLodSize;
		vec2 cLodSizeInv = 1.0 / cLodSize;
		vec4 fSample = bicubic( sampler, uv, vec4( fLodSizeInv, fLodSize ), floor( lod ) );
		vec4 cSample = bicubic( sampler, uv, vec4( cLodSizeInv, cLodSize ), ceil( lod ) );
		return mix( fSample, cSample, fract( lod ) );
	}
	vec3 getVolumeTransmissionRay( const in vec3 n, const in vec3 v, const in float thickness, const in float ior, const in mat4 modelMatrix ) {
		vec3 refractionVector = refract( - v, normalize( n ), 1.0 / ior );
		vec3 modelScale;
		modelScale.x = length( vec3( modelMatrix[ 0 ].xyz ) );
		modelScale.y = length( vec3( modelMatrix[ 1 ].xyz ) );
		modelScale.z = length( vec3( modelMatrix[ 2 ].xyz ) );
		return normalize( refractionVector ) * thickness * modelScale;
	}
	float applyIorToRoughness( const in float roughness, const in float ior ) {
		return roughness * clamp( ior * 2.0 - 2.0, 0.0, 1.0 );
	}
	vec4 getTransmissionSample( const in vec2 fragCoord, const in float roughness, const in float ior ) {
		float lod = log2( transmissionSamplerSize.x ) * applyIorToRoughness( roughness, ior );
		return textureBicubic( transmissionSamplerMap, fragCoord.xy, lod );
	}
	vec3 volumeAttenuation( const in float transmissionDistance, const in vec3 attenuationColor, const in float attenuationDistance ) {
		if ( isinf( attenuationDistance ) ) {
			return vec3( 1.0 );
		} else {
			vec3 attenuationCoefficient = -log( attenuationColor ) / attenuationDistance;
			vec3 transmittance = exp( - attenuationCoefficient * transmissionDistance );			return transmittance;
		}
	}
	vec4 getIBLVolumeRefraction( const in vec3 n, const in vec3 v, const in float roughness, const in vec3 diffuseColor,
		const in vec3 specularColor, const in float specularF90, const in vec3 position, const in mat4 modelMatrix,
		const in mat4 viewMatrix, const in mat4 projMatrix, const in float dispersion, const in float ior, const in float thickness,
		const in vec3 attenuationColor, const in float attenuationDistance ) {
		vec4 transmittedLight;
		vec3 transmittance;
		#ifdef USE_DISPERSION
			float halfSpread = ( ior - 1.0 ) * 0.025 * dispersion;
			vec3 iors = vec3( ior - halfSpread, ior, ior + halfSpread );
			for ( int i = 0; i < 3; i ++ ) {
				vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, iors[ i ], modelMatrix );
				vec3 refractedRayExit = position + transmissionRay;
				vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
				vec2 refractionCoords = ndcPos.xy / ndcPos.w;
				refractionCoords += 1.0;
				refractionCoords /= 2.0;
				vec4 transmissionSample = getTransmissionSample( refractionCoords, roughness, iors[ i ] );
				transmittedLight[ i ] = transmissionSample[ i ];
				transmittedLight.a += transmissionSample.a;
				transmittance[ i ] = diffuseColor[ i ] * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance )[ i ];
			}
			transmittedLight.a /= 3.0;
		#else
			vec3 transmissionRay = getVolumeTransmissionRay( n, v, thickness, ior, modelMatrix );
			vec3 refractedRayExit = position + transmissionRay;
			vec4 ndcPos = projMatrix * viewMatrix * vec4( refractedRayExit, 1.0 );
			vec2 refractionCoords = ndcPos.xy / ndcPos.w;
			refractionCoords += 1.0;
			refractionCoords /= 2.0;
			transmittedLight = getTransmissionSample( refractionCoords, roughness, ior );
			transmittance = diffuseColor * volumeAttenuation( length( transmissionRay ), attenuationColor, attenuationDistance );
		#endif
		vec3 attenuatedColor = transmittance * transmittedLight.rgb;
		vec3 F = EnvironmentBRDF( n, v, specularColor, specularF90, roughness );
		float transmittanceFactor = ( transmittance.r + transmittance.g + transmittance.b ) / 3.0;
		return vec4( ( 1.0 - F ) * attenuatedColor, 1.0 - ( 1.0 - transmittedLight.a ) * transmittanceFactor );
	}
#endif`,c_=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_SPECULARMAP
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,h_=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	varying vec2 vUv;
#endif
#ifdef USE_MAP
	uniform mat3 mapTransform;
	varying vec2 vMapUv;
#endif
#ifdef USE_ALPHAMAP
	uniform mat3 alphaMapTransform;
	varying vec2 vAlphaMapUv;
#endif
#ifdef USE_LIGHTMAP
	uniform mat3 lightMapTransform;
	varying vec2 vLightMapUv;
#endif
#ifdef USE_AOMAP
	uniform mat3 aoMapTransform;
	varying vec2 vAoMapUv;
#endif
#ifdef USE_BUMPMAP
	uniform mat3 bumpMapTransform;
	varying vec2 vBumpMapUv;
#endif
#ifdef USE_NORMALMAP
	uniform mat3 normalMapTransform;
	varying vec2 vNormalMapUv;
#endif
#ifdef USE_DISPLACEMENTMAP
	uniform mat3 displacementMapTransform;
	varying vec2 vDisplacementMapUv;
#endif
#ifdef USE_EMISSIVEMAP
	uniform mat3 emissiveMapTransform;
	varying vec2 vEmissiveMapUv;
#endif
#ifdef USE_METALNESSMAP
	uniform mat3 metalnessMapTransform;
	varying vec2 vMetalnessMapUv;
#endif
#ifdef USE_ROUGHNESSMAP
	uniform mat3 roughnessMapTransform;
	varying vec2 vRoughnessMapUv;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	uniform mat3 diffuseRoughnessMapTransform;
	varying vec2 vDiffuseRoughnessMapUv;
#endif
#ifdef USE_ANISOTROPYMAP
	uniform mat3 anisotropyMapTransform;
	varying vec2 vAnisotropyMapUv;
#endif
#ifdef USE_CLEARCOATMAP
	uniform mat3 clearcoatMapTransform;
	varying vec2 vClearcoatMapUv;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	uniform mat3 clearcoatNormalMapTransform;
	varying vec2 vClearcoatNormalMapUv;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	uniform mat3 clearcoatRoughnessMapTransform;
	varying vec2 vClearcoatRoughnessMapUv;
#endif
#ifdef USE_SHEEN_COLORMAP
	uniform mat3 sheenColorMapTransform;
	varying vec2 vSheenColorMapUv;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	uniform mat3 sheenRoughnessMapTransform;
	varying vec2 vSheenRoughnessMapUv;
#endif
#ifdef USE_IRIDESCENCEMAP
	uniform mat3 iridescenceMapTransform;
	varying vec2 vIridescenceMapUv;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	uniform mat3 iridescenceThicknessMapTransform;
	varying vec2 vIridescenceThicknessMapUv;
#endif
#ifdef USE_SPECULARMAP
	uniform mat3 specularMapTransform;
	varying vec2 vSpecularMapUv;
#endif
#ifdef USE_SPECULAR_COLORMAP
	uniform mat3 specularColorMapTransform;
	varying vec2 vSpecularColorMapUv;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	uniform mat3 specularIntensityMapTransform;
	varying vec2 vSpecularIntensityMapUv;
#endif
#ifdef USE_TRANSMISSIONMAP
	uniform mat3 transmissionMapTransform;
	varying vec2 vTransmissionMapUv;
#endif
#ifdef USE_THICKNESSMAP
	uniform mat3 thicknessMapTransform;
	varying vec2 vThicknessMapUv;
#endif`,u_=`#if defined( USE_UV ) || defined( USE_ANISOTROPY )
	vUv = vec3( uv, 1 ).xy;
#endif
#ifdef USE_MAP
	vMapUv = ( mapTransform * vec3( MAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ALPHAMAP
	vAlphaMapUv = ( alphaMapTransform * vec3( ALPHAMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_LIGHTMAP
	vLightMapUv = ( lightMapTransform * vec3( LIGHTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_AOMAP
	vAoMapUv = ( aoMapTransform * vec3( AOMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_BUMPMAP
	vBumpMapUv = ( bumpMapTransform * vec3( BUMPMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_NORMALMAP
	vNormalMapUv = ( normalMapTransform * vec3( NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DISPLACEMENTMAP
	vDisplacementMapUv = ( displacementMapTransform * vec3( DISPLACEMENTMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_EMISSIVEMAP
	vEmissiveMapUv = ( emissiveMapTransform * vec3( EMISSIVEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_METALNESSMAP
	vMetalnessMapUv = ( metalnessMapTransform * vec3( METALNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ROUGHNESSMAP
	vRoughnessMapUv = ( roughnessMapTransform * vec3( ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_DIFFUSE_ROUGHNESSMAP
	vDiffuseRoughnessMapUv = ( diffuseRoughnessMapTransform * vec3( DIFFUSE_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_ANISOTROPYMAP
	vAnisotropyMapUv = ( anisotropyMapTransform * vec3( ANISOTROPYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOATMAP
	vClearcoatMapUv = ( clearcoatMapTransform * vec3( CLEARCOATMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_NORMALMAP
	vClearcoatNormalMapUv = ( clearcoatNormalMapTransform * vec3( CLEARCOAT_NORMALMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_CLEARCOAT_ROUGHNESSMAP
	vClearcoatRoughnessMapUv = ( clearcoatRoughnessMapTransform * vec3( CLEARCOAT_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCEMAP
	vIridescenceMapUv = ( iridescenceMapTransform * vec3( IRIDESCENCEMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_IRIDESCENCE_THICKNESSMAP
	vIridescenceThicknessMapUv = ( iridescenceThicknessMapTransform * vec3( IRIDESCENCE_THICKNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_COLORMAP
	vSheenColorMapUv = ( sheenColorMapTransform * vec3( SHEEN_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SHEEN_ROUGHNESSMAP
	vSheenRoughnessMapUv = ( sheenRoughnessMapTransform * vec3( SHEEN_ROUGHNESSMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULARMAP
	vSpecularMapUv = ( specularMapTransform * vec3( SPECULARMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_COLORMAP
	vSpecularColorMapUv = ( specularColorMapTransform * vec3( SPECULAR_COLORMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_SPECULAR_INTENSITYMAP
	vSpecularIntensityMapUv = ( specularIntensityMapTransform * vec3( SPECULAR_INTENSITYMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_TRANSMISSIONMAP
	vTransmissionMapUv = ( transmissionMapTransform * vec3( TRANSMISSIONMAP_UV, 1 ) ).xy;
#endif
#ifdef USE_THICKNESSMAP
	vThicknessMapUv = ( thicknessMapTransform * vec3( THICKNESSMAP_UV, 1 ) ).xy;
#endif`,f_=`#if defined( USE_ENVMAP ) || defined( DISTANCE ) || defined ( USE_SHADOWMAP ) || defined ( USE_TRANSMISSION ) || NUM_SPOT_LIGHT_COORDS > 0
	vec4 worldPosition = vec4( transformed, 1.0 );
	#ifdef USE_BATCHING
		worldPosition = batchingMatrix * worldPosition;
	#endif
	#ifdef USE_INSTANCING
		worldPosition = instanceMatrix * worldPosition;
	#endif
	worldPosition = modelMatrix * worldPosition;
#endif`,d_=`varying vec2 vUv;
uniform mat3 uvTransform;
void main() {
	vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	gl_Position = vec4( position.xy, 1.0, 1.0 );
}`,p_=`uniform sampler2D t2D;
uniform float backgroundIntensity;
varying vec2 vUv;
void main() {
	vec4 texColor = texture2D( t2D, vUv );
	#ifdef DECODE_VIDEO_TEXTURE
		texColor = vec4( mix( pow( texColor.rgb * 0.9478672986 + vec3( 0.0521327014 ), vec3( 2.4 ) ), texColor.rgb * 0.0773993808, vec3( lessThanEqual( texColor.rgb, vec3( 0.04045 ) ) ) ), texColor.w );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,m_=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,g_=`uniform float backgroundBlurriness;
uniform float backgroundIntensity;
uniform mat3 backgroundRotation;
varying vec3 vWorldDirection;
#include <envmap_common_pars_fragment>
void main() {
	#ifdef ENVMAP_TYPE_PMREM
		vec4 texColor = textureLod( envMap, backgroundRotation * vWorldDirection, roughnessToMip( backgroundBlurriness ) );
	#else
		vec4 texColor = textureCube( envMap, backgroundRotation * vWorldDirection );
	#endif
	texColor.rgb *= backgroundIntensity;
	gl_FragColor = texColor;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,__=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
	gl_Position.z = gl_Position.w;
}`,x_=`uniform samplerCube tCube;
uniform float tFlip;
uniform float opacity;
varying vec3 vWorldDirection;
void main() {
	vec4 texColor = textureCube( tCube, vec3( tFlip * vWorldDirection.x, vWorldDirection.yz ) );
	gl_FragColor = texColor;
	gl_FragColor.a *= opacity;
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,v_=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
varying vec2 vHighPrecisionZW;
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vHighPrecisionZW = gl_Position.zw;
}`,y_=`#if DEPTH_PACKING == 3200
	uniform float opacity;
#endif
#include <common>
#include <packing>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
varying vec2 vHighPrecisionZW;
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#if DEPTH_PACKING == 3200
		diffuseColor.a = opacity;
	#endif
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <logdepthbuf_fragment>
	#ifdef USE_REVERSED_DEPTH_BUFFER
		float fragCoordZ = vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ];
	#else
		float fragCoordZ = 0.5 * vHighPrecisionZW[ 0 ] / vHighPrecisionZW[ 1 ] + 0.5;
	#endif
	#if DEPTH_PACKING == 3200
		gl_FragColor = vec4( vec3( 1.0 - fragCoordZ ), opacity );
	#elif DEPTH_PACKING == 3201
		gl_FragColor = packDepthToRGBA( fragCoordZ );
	#elif DEPTH_PACKING == 3202
		gl_FragColor = vec4( packDepthToRGB( fragCoordZ ), 1.0 );
	#elif DEPTH_PACKING == 3203
		gl_FragColor = vec4( packDepthToRG( fragCoordZ ), 0.0, 1.0 );
	#endif
}`,S_=`#define DISTANCE
varying vec3 vWorldPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <skinbase_vertex>
	#include <morphinstance_vertex>
	#ifdef USE_DISPLACEMENTMAP
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <worldpos_vertex>
	#include <clipping_planes_vertex>
	vWorldPosition = worldPosition.xyz;
}`,M_=`#define DISTANCE
uniform vec3 referencePosition;
uniform float nearDistance;
uniform float farDistance;
varying vec3 vWorldPosition;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 1.0 );
	#include <clipping_planes_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	float dist = length( vWorldPosition - referencePosition );
	dist = ( dist - nearDistance ) / ( farDistance - nearDistance );
	dist = saturate( dist );
	gl_FragColor = vec4( dist, 0.0, 0.0, 1.0 );
}`,b_=`varying vec3 vWorldDirection;
#include <common>
void main() {
	vWorldDirection = transformDirection( position, modelMatrix );
	#include <begin_vertex>
	#include <project_vertex>
}`,w_=`uniform sampler2D tEquirect;
varying vec3 vWorldDirection;
#include <common>
void main() {
	vec3 direction = normalize( vWorldDirection );
	vec2 sampleUV = equirectUv( direction );
	gl_FragColor = texture2D( tEquirect, sampleUV );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
}`,E_=`uniform float scale;
attribute float lineDistance;
varying float vLineDistance;
#include <common>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	vLineDistance = scale * lineDistance;
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,A_=`uniform vec3 diffuse;
uniform float opacity;
uniform float dashSize;
uniform float totalSize;
varying float vLineDistance;
#include <common>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	if ( mod( vLineDistance, totalSize ) > dashSize ) {
		discard;
	}
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,T_=`#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#if defined ( USE_ENVMAP ) || defined ( USE_SKINNING )
		#include <beginnormal_vertex>
		#include <morphnormal_vertex>
		#include <skinbase_vertex>
		#include <skinnormal_vertex>
		#include <defaultnormal_vertex>
	#endif
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <fog_vertex>
}`,R_=`uniform vec3 diffuse;
uniform float opacity;
#ifndef FLAT_SHADED
	varying vec3 vNormal;
#endif
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <fog_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	#ifdef USE_LIGHTMAP
		vec4 lightMapTexel = texture2D( lightMap, vLightMapUv );
		reflectedLight.indirectDiffuse += lightMapTexel.rgb * lightMapIntensity * RECIPROCAL_PI;
	#else
		reflectedLight.indirectDiffuse += vec3( 1.0 );
	#endif
	#include <aomap_fragment>
	reflectedLight.indirectDiffuse *= diffuseColor.rgb;
	vec3 outgoingLight = reflectedLight.indirectDiffuse;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,C_=`#define LAMBERT
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,I_=`#define LAMBERT
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_lambert_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_lambert_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,P_=`#define MATCAP
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <color_pars_vertex>
#include <displacementmap_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
	vViewPosition = - mvPosition.xyz;
}`,N_=`#define MATCAP
uniform vec3 diffuse;
uniform float opacity;
uniform sampler2D matcap;
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	vec3 viewDir = normalize( vViewPosition );
	vec3 x = normalize( vec3( viewDir.z, 0.0, - viewDir.x ) );
	vec3 y = cross( viewDir, x );
	vec2 uv = vec2( dot( x, normal ), dot( y, normal ) ) * 0.495 + 0.5;
	#ifdef USE_MATCAP
		vec4 matcapColor = texture2D( matcap, uv );
	#else
		vec4 matcapColor = vec4( vec3( mix( 0.2, 0.8, uv.y ) ), 1.0 );
	#endif
	vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,L_=`#define NORMAL
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	vViewPosition = - mvPosition.xyz;
#endif
}`,D_=`#define NORMAL
uniform float opacity;
#if defined( FLAT_SHADED ) || defined( USE_BUMPMAP ) || defined( USE_NORMALMAP_TANGENTSPACE )
	varying vec3 vViewPosition;
#endif
#include <uv_pars_fragment>
#include <normal_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( 0.0, 0.0, 0.0, opacity );
	#include <clipping_planes_fragment>
	#include <logdepthbuf_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	gl_FragColor = vec4( normalize( normal ) * 0.5 + 0.5, diffuseColor.a );
	#ifdef OPAQUE
		gl_FragColor.a = 1.0;
	#endif
}`,U_=`#define PHONG
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <envmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <envmap_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,F_=`#define PHONG
uniform vec3 diffuse;
uniform vec3 emissive;
uniform vec3 specular;
uniform float shininess;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_phong_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <specularmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <specularmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_phong_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + reflectedLight.directSpecular + reflectedLight.indirectSpecular + totalEmissiveRadiance;
	#include <envmap_fragment>
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,O_=`#define STANDARD
varying vec3 vViewPosition;
#ifdef USE_TRANSMISSION
	varying vec3 vWorldPosition;
#endif
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
#ifdef USE_TRANSMISSION
	vWorldPosition = worldPosition.xyz;
#endif
}`,B_=`#define STANDARD
#ifdef PHYSICAL
	#define IOR
	#define USE_SPECULAR
#endif
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float roughness;
uniform float metalness;
uniform float opacity;
#ifdef IOR
	uniform float ior;
#endif
#ifdef USE_SPECULAR
	uniform float specularIntensity;
	uniform vec3 specularColor;
	#ifdef USE_SPECULAR_COLORMAP
		uniform sampler2D specularColorMap;
	#endif
	#ifdef USE_SPECULAR_INTENSITYMAP
		uniform sampler2D specularIntensityMap;
	#endif
#endif
#ifdef USE_CLEARCOAT
	uniform float clearcoat;
	uniform float clearcoatRoughness;
#endif
#ifdef USE_DIFFUSE_ROUGHNESS
	uniform float diffuseRoughness;
	#ifdef USE_DIFFUSE_ROUGHNESSMAP
		uniform sampler2D diffuseRoughnessMap;
	#endif
#endif
#ifdef USE_DISPERSION
	uniform float dispersion;
#endif
#ifdef USE_RETROREFLECTION
	uniform float retroreflectivity;
#endif
#ifdef USE_IRIDESCENCE
	uniform float iridescence;
	uniform float iridescenceIOR;
	uniform float iridescenceThicknessMinimum;
	uniform float iridescenceThicknessMaximum;
#endif
#ifdef USE_SHEEN
	uniform vec3 sheenColor;
	uniform float sheenRoughness;
	#ifdef USE_SHEEN_COLORMAP
		uniform sampler2D sheenColorMap;
	#endif
	#ifdef USE_SHEEN_ROUGHNESSMAP
		uniform sampler2D sheenRoughnessMap;
	#endif
#endif
#ifdef USE_ANISOTROPY
	uniform vec2 anisotropyVector;
	#ifdef USE_ANISOTROPYMAP
		uniform sampler2D anisotropyMap;
	#endif
#endif
varying vec3 vViewPosition;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <iridescence_fragment>
#include <envmap_common_pars_fragment>
#include <envmap_physical_pars_fragment>
#include <fog_pars_fragment>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_physical_pars_fragment>
#include <transmission_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <clearcoat_pars_fragment>
#include <iridescence_pars_fragment>
#include <roughnessmap_pars_fragment>
#include <metalnessmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <roughnessmap_fragment>
	#include <metalnessmap_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <clearcoat_normal_fragment_begin>
	#include <clearcoat_normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_physical_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 totalDiffuse = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse;
	vec3 totalSpecular = reflectedLight.directSpecular + reflectedLight.indirectSpecular;
	#include <transmission_fragment>
	vec3 outgoingLight = totalDiffuse + totalSpecular + totalEmissiveRadiance;
	#ifdef USE_SHEEN
 
		outgoingLight = outgoingLight + sheenSpecularDirect + sheenSpecularIndirect;
 
 	#endif
	#ifdef USE_CLEARCOAT
		float dotNVcc = saturate( dot( geometryClearcoatNormal, geometryViewDir ) );
		vec3 Fcc = F_Schlick( material.clearcoatF0, material.clearcoatF90, dotNVcc );
		outgoingLight = outgoingLight * ( 1.0 - material.clearcoat * Fcc ) + ( clearcoatSpecularDirect + clearcoatSpecularIndirect ) * material.clearcoat;
	#endif
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,z_=`#define TOON
varying vec3 vViewPosition;
#include <common>
#include <batching_pars_vertex>
#include <uv_pars_vertex>
#include <displacementmap_pars_vertex>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <normal_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <shadowmap_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <normal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <displacementmap_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	vViewPosition = - mvPosition.xyz;
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,k_=`#define TOON
uniform vec3 diffuse;
uniform vec3 emissive;
uniform float opacity;
#include <common>
#include <dithering_pars_fragment>
#include <color_pars_fragment>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <aomap_pars_fragment>
#include <lightmap_pars_fragment>
#include <emissivemap_pars_fragment>
#include <gradientmap_pars_fragment>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <normal_pars_fragment>
#include <lights_toon_pars_fragment>
#include <shadowmap_pars_fragment>
#include <bumpmap_pars_fragment>
#include <normalmap_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	ReflectedLight reflectedLight = ReflectedLight( vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ), vec3( 0.0 ) );
	vec3 totalEmissiveRadiance = emissive;
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <color_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	#include <normal_fragment_begin>
	#include <normal_fragment_maps>
	#include <emissivemap_fragment>
	#include <lights_toon_fragment>
	#include <lights_fragment_begin>
	#include <lights_fragment_maps>
	#include <lights_fragment_end>
	#include <aomap_fragment>
	vec3 outgoingLight = reflectedLight.directDiffuse + reflectedLight.indirectDiffuse + totalEmissiveRadiance;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
	#include <dithering_fragment>
}`,G_=`uniform float size;
uniform float scale;
#include <common>
#include <color_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
#ifdef USE_POINTS_UV
	varying vec2 vUv;
	uniform mat3 uvTransform;
#endif
void main() {
	#ifdef USE_POINTS_UV
		vUv = ( uvTransform * vec3( uv, 1 ) ).xy;
	#endif
	#include <color_vertex>
	#include <morphinstance_vertex>
	#include <morphcolor_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <project_vertex>
	gl_PointSize = size;
	#ifdef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) gl_PointSize *= ( scale / - mvPosition.z );
	#endif
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <worldpos_vertex>
	#include <fog_vertex>
}`,V_=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <color_pars_fragment>
#include <map_particle_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_particle_fragment>
	#include <color_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,H_=`#include <common>
#include <batching_pars_vertex>
#include <fog_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <shadowmap_pars_vertex>
void main() {
	#include <batching_vertex>
	#include <beginnormal_vertex>
	#include <morphinstance_vertex>
	#include <morphnormal_vertex>
	#include <skinbase_vertex>
	#include <skinnormal_vertex>
	#include <defaultnormal_vertex>
	#include <begin_vertex>
	#include <morphtarget_vertex>
	#include <skinning_vertex>
	#include <project_vertex>
	#include <logdepthbuf_vertex>
	#include <worldpos_vertex>
	#include <shadowmap_vertex>
	#include <fog_vertex>
}`,W_=`uniform vec3 color;
uniform float opacity;
#include <common>
#include <fog_pars_fragment>
#include <bsdfs>
#include <lights_pars_begin>
#include <logdepthbuf_pars_fragment>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
void main() {
	#include <logdepthbuf_fragment>
	gl_FragColor = vec4( color, opacity * ( 1.0 - getShadowMask() ) );
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
	#include <premultiplied_alpha_fragment>
}`,X_=`uniform float rotation;
uniform vec2 center;
#include <common>
#include <uv_pars_vertex>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
void main() {
	#include <uv_vertex>
	vec4 mvPosition = modelViewMatrix[ 3 ];
	vec2 scale = vec2( length( modelMatrix[ 0 ].xyz ), length( modelMatrix[ 1 ].xyz ) );
	#ifndef USE_SIZEATTENUATION
		bool isPerspective = isPerspectiveMatrix( projectionMatrix );
		if ( isPerspective ) scale *= - mvPosition.z;
	#endif
	vec2 alignedPosition = ( position.xy - ( center - vec2( 0.5 ) ) ) * scale;
	vec2 rotatedPosition;
	rotatedPosition.x = cos( rotation ) * alignedPosition.x - sin( rotation ) * alignedPosition.y;
	rotatedPosition.y = sin( rotation ) * alignedPosition.x + cos( rotation ) * alignedPosition.y;
	mvPosition.xy += rotatedPosition;
	gl_Position = projectionMatrix * mvPosition;
	#include <logdepthbuf_vertex>
	#include <clipping_planes_vertex>
	#include <fog_vertex>
}`,q_=`uniform vec3 diffuse;
uniform float opacity;
#include <common>
#include <uv_pars_fragment>
#include <map_pars_fragment>
#include <alphamap_pars_fragment>
#include <alphatest_pars_fragment>
#include <alphahash_pars_fragment>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
void main() {
	vec4 diffuseColor = vec4( diffuse, opacity );
	#include <clipping_planes_fragment>
	vec3 outgoingLight = vec3( 0.0 );
	#include <logdepthbuf_fragment>
	#include <map_fragment>
	#include <alphamap_fragment>
	#include <alphatest_fragment>
	#include <alphahash_fragment>
	outgoingLight = diffuseColor.rgb;
	#include <opaque_fragment>
	#include <tonemapping_fragment>
	#include <colorspace_fragment>
	#include <fog_fragment>
}`,nt={alphahash_fragment:pg,alphahash_pars_fragment:mg,alphamap_fragment:gg,alphamap_pars_fragment:_g,alphatest_fragment:xg,alphatest_pars_fragment:vg,aomap_fragment:yg,aomap_pars_fragment:Sg,batching_pars_vertex:Mg,batching_vertex:bg,begin_vertex:wg,beginnormal_vertex:Eg,bsdfs:Ag,iridescence_fragment:Tg,bumpmap_pars_fragment:Rg,clipping_planes_fragment:Cg,clipping_planes_pars_fragment:Ig,clipping_planes_pars_vertex:Pg,clipping_planes_vertex:Ng,color_fragment:Lg,color_pars_fragment:Dg,color_pars_vertex:Ug,color_vertex:Fg,common:Og,defaultnormal_vertex:Bg,displacementmap_pars_vertex:zg,displacementmap_vertex:kg,emissivemap_fragment:Gg,emissivemap_pars_fragment:Vg,colorspace_fragment:Hg,colorspace_pars_fragment:Wg,envmap_fragment:Xg,envmap_common_pars_fragment:qg,envmap_pars_fragment:Yg,envmap_pars_vertex:Zg,envmap_physical_pars_fragment:s0,envmap_vertex:Jg,fog_vertex:$g,fog_pars_vertex:Kg,fog_fragment:Qg,fog_pars_fragment:jg,gradientmap_pars_fragment:t0,lightmap_pars_fragment:e0,lights_lambert_fragment:n0,lights_lambert_pars_fragment:i0,lights_pars_begin:r0,lights_toon_fragment:a0,lights_toon_pars_fragment:o0,lights_phong_fragment:l0,lights_phong_pars_fragment:c0,lights_physical_fragment:h0,lights_physical_pars_fragment:u0,lights_fragment_begin:f0,lights_fragment_maps:d0,lights_fragment_end:p0,lightprobes_pars_fragment:m0,logdepthbuf_fragment:g0,logdepthbuf_pars_fragment:_0,logdepthbuf_pars_vertex:x0,logdepthbuf_vertex:v0,map_fragment:y0,map_pars_fragment:S0,map_particle_fragment:M0,map_particle_pars_fragment:b0,metalnessmap_fragment:w0,metalnessmap_pars_fragment:E0,morphinstance_vertex:A0,morphcolor_vertex:T0,morphnormal_vertex:R0,morphtarget_pars_vertex:C0,morphtarget_vertex:I0,normal_fragment_begin:P0,normal_fragment_maps:N0,normal_pars_fragment:L0,normal_pars_vertex:D0,normal_vertex:U0,normalmap_pars_fragment:F0,clearcoat_normal_fragment_begin:O0,clearcoat_normal_fragment_maps:B0,clearcoat_pars_fragment:z0,iridescence_pars_fragment:k0,opaque_fragment:G0,packing:V0,premultiplied_alpha_fragment:H0,project_vertex:W0,dithering_fragment:X0,dithering_pars_fragment:q0,roughnessmap_fragment:Y0,roughnessmap_pars_fragment:Z0,shadowmap_pars_fragment:J0,shadowmap_pars_vertex:$0,shadowmap_vertex:K0,shadowmask_pars_fragment:Q0,skinbase_vertex:j0,skinning_pars_vertex:t_,skinning_vertex:e_,skinnormal_vertex:n_,specularmap_fragment:i_,specularmap_pars_fragment:r_,tonemapping_fragment:s_,tonemapping_pars_fragment:a_,transmission_fragment:o_,transmission_pars_fragment:l_,uv_pars_fragment:c_,uv_pars_vertex:h_,uv_vertex:u_,worldpos_vertex:f_,background_vert:d_,background_frag:p_,backgroundCube_vert:m_,backgroundCube_frag:g_,cube_vert:__,cube_frag:x_,depth_vert:v_,depth_frag:y_,distance_vert:S_,distance_frag:M_,equirect_vert:b_,equirect_frag:w_,linedashed_vert:E_,linedashed_frag:A_,meshbasic_vert:T_,meshbasic_frag:R_,meshlambert_vert:C_,meshlambert_frag:I_,meshmatcap_vert:P_,meshmatcap_frag:N_,meshnormal_vert:L_,meshnormal_frag:D_,meshphong_vert:U_,meshphong_frag:F_,meshphysical_vert:O_,meshphysical_frag:B_,meshtoon_vert:z_,meshtoon_frag:k_,points_vert:G_,points_frag:V_,shadow_vert:H_,shadow_frag:W_,sprite_vert:X_,sprite_frag:q_},k={common:{diffuse:{value:new Ft(16777215)},opacity:{value:1},map:{value:null},mapTransform:{value:new K},alphaMap:{value:null},alphaMapTransform:{value:new K},alphaTest:{value:0}},specularmap:{specularMap:{value:null},specularMapTransform:{value:new K}},envmap:{envMap:{value:null},envMapRotation:{value:new K},reflectivity:{value:1},ior:{value:1.5},refractionRatio:{value:.98},dfgLUT:{value:null}},aomap:{aoMap:{value:null},aoMapIntensity:{value:1},aoMapTransform:{value:new K}},lightmap:{lightMap:{value:null},lightMapIntensity:{value:1},lightMapTransform:{value:new K}},bumpmap:{bumpMap:{value:null},bumpMapTransform:{value:new K},bumpScale:{value:1}},normalmap:{normalMap:{value:null},normalMapTransform:{value:new K},normalScale:{value:new oe(1,1)}},displacementmap:{displacementMap:{value:null},displacementMapTransform:{value:new K},displacementScale:{value:1},displacementBias:{value:0}},emissivemap:{emissiveMap:{value:null},emissiveMapTransform:{value:new K}},metalnessmap:{metalnessMap:{value:null},metalnessMapTransform:{value:new K}},roughnessmap:{roughnessMap:{value:null},roughnessMapTransform:{value:new K}},gradientmap:{gradientMap:{value:null}},fog:{fogDensity:{value:25e-5},fogNear:{value:1},fogFar:{value:2e3},fogColor:{value:new Ft(16777215)}},lights:{ambientLightColor:{value:[]},lightProbe:{value:[]},sunLights:{value:[],properties:{direction:{},color:{}}},sunLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},sunShadowMatrix:{value:[]},sunShadowCascade:{value:[]},directionalLights:{value:[],properties:{direction:{},color:{}}},directionalLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},directionalShadowMatrix:{value:[]},spotLights:{value:[],properties:{color:{},position:{},direction:{},distance:{},coneCos:{},penumbraCos:{},decay:{}}},spotLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{}}},spotLightMap:{value:[]},spotLightMatrix:{value:[]},pointLights:{value:[],properties:{color:{},position:{},decay:{},distance:{}}},pointLightShadows:{value:[],properties:{shadowIntensity:1,shadowBias:{},shadowNormalBias:{},shadowRadius:{},shadowMapSize:{},shadowCameraNear:{},shadowCameraFar:{}}},pointShadowMatrix:{value:[]},hemisphereLights:{value:[],properties:{direction:{},skyColor:{},groundColor:{}}},rectAreaLights:{value:[],properties:{color:{},position:{},width:{},height:{}}},ltc_1:{value:null},ltc_2:{value:null},probesSH:{value:[]},probesMin:{value:[]},probesMax:{value:[]},probesResolution:{value:[]}},points:{diffuse:{value:new Ft(16777215)},opacity:{value:1},size:{value:1},scale:{value:1},map:{value:null},alphaMap:{value:null},alphaMapTransform:{value:new K},alphaTest:{value:0},uvTransform:{value:new K}},sprite:{diffuse:{value:new Ft(16777215)},opacity:{value:1},center:{value:new oe(.5,.5)},rotation:{value:0},map:{value:null},mapTransform:{value:new K},alphaMap:{value:null},alphaMapTransform:{value:new K},alphaTest:{value:0}}},Wc={basic:{uniforms:ee([k.common,k.specularmap,k.envmap,k.aomap,k.lightmap,k.fog]),vertexShader:nt.meshbasic_vert,fragmentShader:nt.meshbasic_frag},lambert:{uniforms:ee([k.common,k.specularmap,k.envmap,k.aomap,k.lightmap,k.emissivemap,k.bumpmap,k.normalmap,k.displacementmap,k.fog,k.lights,{emissive:{value:new Ft(0)},envMapIntensity:{value:1}}]),vertexShader:nt.meshlambert_vert,fragmentShader:nt.meshlambert_frag},phong:{uniforms:ee([k.common,k.specularmap,k.envmap,k.aomap,k.lightmap,k.emissivemap,k.bumpmap,k.normalmap,k.displacementmap,k.fog,k.lights,{emissive:{value:new Ft(0)},specular:{value:new Ft(1118481)},shininess:{value:30},envMapIntensity:{value:1}}]),vertexShader:nt.meshphong_vert,fragmentShader:nt.meshphong_frag},standard:{uniforms:ee([k.common,k.envmap,k.aomap,k.lightmap,k.emissivemap,k.bumpmap,k.normalmap,k.displacementmap,k.roughnessmap,k.metalnessmap,k.fog,k.lights,{emissive:{value:new Ft(0)},roughness:{value:1},metalness:{value:0},envMapIntensity:{value:1}}]),vertexShader:nt.meshphysical_vert,fragmentShader:nt.meshphysical_frag},toon:{uniforms:ee([k.common,k.aomap,k.lightmap,k.emissivemap,k.bumpmap,k.normalmap,k.displacementmap,k.gradientmap,k.fog,k.lights,{emissive:{value:new Ft(0)}}]),vertexShader:nt.meshtoon_vert,fragmentShader:nt.meshtoon_frag},matcap:{uniforms:ee([k.common,k.bumpmap,k.normalmap,k.displacementmap,k.fog,{matcap:{value:null}}]),vertexShader:nt.meshmatcap_vert,fragmentShader:nt.meshmatcap_frag},points:{uniforms:ee([k.points,k.fog]),vertexShader:nt.points_vert,fragmentShader:nt.points_frag},dashed:{uniforms:ee([k.common,k.fog,{scale:{value:1},dashSize:{value:1},totalSize:{value:2}}]),vertexShader:nt.linedashed_vert,fragmentShader:nt.linedashed_frag},depth:{uniforms:ee([k.common,k.displacementmap]),vertexShader:nt.depth_vert,fragmentShader:nt.depth_frag},normal:{uniforms:ee([k.common,k.bumpmap,k.normalmap,k.displacementmap,{opacity:{value:1}}]),vertexShader:nt.meshnormal_vert,fragmentShader:nt.meshnormal_frag},sprite:{uniforms:ee([k.sprite,k.fog]),vertexShader:nt.sprite_vert,fragmentShader:nt.sprite_frag},background:{uniforms:{uvTransform:{value:new K},t2D:{value:null},backgroundIntensity:{value:1}},vertexShader:nt.background_vert,fragmentShader:nt.background_frag},backgroundCube:{uniforms:{envMap:{value:null},backgroundBlurriness:{value:0},backgroundIntensity:{value:1},backgroundRotation:{value:new K}},vertexShader:nt.backgroundCube_vert,fragmentShader:nt.backgroundCube_frag},cube:{uniforms:{tCube:{value:null},tFlip:{value:-1},opacity:{value:1}},vertexShader:nt.cube_vert,fragmentShader:nt.cube_frag},equirect:{uniforms:{tEquirect:{value:null}},vertexShader:nt.equirect_vert,fragmentShader:nt.equirect_frag},distance:{uniforms:ee([k.common,k.displacementmap,{referencePosition:{value:new st},nearDistance:{value:1},farDistance:{value:1e3}}]),vertexShader:nt.distance_vert,fragmentShader:nt.distance_frag},shadow:{uniforms:ee([k.lights,k.fog,{color:{value:new Ft(0)},opacity:{value:1}}]),vertexShader:nt.shadow_vert,fragmentShader:nt.shadow_frag}};Wc.physical={uniforms:ee([Wc.standard.uniforms,{clearcoat:{value:0},clearcoatMap:{value:null},clearcoatMapTransform:{value:new K},clearcoatNormalMap:{value:null},clearcoatNormalMapTransform:{value:new K},clearcoatNormalScale:{value:new oe(1,1)},clearcoatRoughness:{value:0},clearcoatRoughnessMap:{value:null},clearcoatRoughnessMapTransform:{value:new K},diffuseRoughness:{value:0},diffuseRoughnessMap:{value:null},diffuseRoughnessMapTransform:{value:new K},dispersion:{value:0},retroreflectivity:{value:0},iridescence:{value:0},iridescenceMap:{value:null},iridescenceMapTransform:{value:new K},iridescenceIOR:{value:1.3},iridescenceThicknessMinimum:{value:100},iridescenceThicknessMaximum:{value:400},iridescenceThicknessMap:{value:null},iridescenceThicknessMapTransform:{value:new K},sheen:{value:0},sheenColor:{value:new Ft(0)},sheenColorMap:{value:null},sheenColorMapTransform:{value:new K},sheenRoughness:{value:1},sheenRoughnessMap:{value:null},sheenRoughnessMapTransform:{value:new K},transmission:{value:0},transmissionMap:{value:null},transmissionMapTransform:{value:new K},transmissionSamplerSize:{value:new oe},transmissionSamplerMap:{value:null},thickness:{value:0},thicknessMap:{value:null},thicknessMapTransform:{value:new K},attenuationDistance:{value:0},attenuationColor:{value:new Ft(0)},specularColor:{value:new Ft(1,1,1)},specularColorMap:{value:null},specularColorMapTransform:{value:new K},specularIntensity:{value:1},specularIntensityMap:{value:null},specularIntensityMapTransform:{value:new K},anisotropyVector:{value:new oe},anisotropyMap:{value:null},anisotropyMapTransform:{value:new K}}]),vertexShader:nt.meshphysical_vert,fragmentShader:nt.meshphysical_frag};var Y_=new K;Y_.set(-1,0,0,0,1,0,0,0,1);var jI={[wo]:"LINEAR_TONE_MAPPING",[Eo]:"REINHARD_TONE_MAPPING",[Ao]:"CINEON_TONE_MAPPING",[To]:"ACES_FILMIC_TONE_MAPPING",[Co]:"AGX_TONE_MAPPING",[Io]:"NEUTRAL_TONE_MAPPING",[Ro]:"CUSTOM_TONE_MAPPING"};var t3=new Float32Array(16),e3=new Float32Array(9),n3=new Float32Array(4);var i3={[wo]:"Linear",[Eo]:"Reinhard",[Ao]:"Cineon",[To]:"ACESFilmic",[Co]:"AgX",[Io]:"Neutral",[Ro]:"Custom"};var r3={[Tc]:"SHADOWMAP_TYPE_PCF",[Rc]:"SHADOWMAP_TYPE_VSM"};var s3={[Nc]:"ENVMAP_MODE_REFRACTION"};var a3={[Cc]:"ENVMAP_BLENDING_MULTIPLY",[Ic]:"ENVMAP_BLENDING_MIX",[Pc]:"ENVMAP_BLENDING_ADD"};var Z_=new K;Z_.set(-1,0,0,0,1,0,0,0,1);var o3=new Uint16Array([12469,15057,12620,14925,13266,14620,13807,14376,14323,13990,14545,13625,14713,13328,14840,12882,14931,12528,14996,12233,15039,11829,15066,11525,15080,11295,15085,10976,15082,10705,15073,10495,13880,14564,13898,14542,13977,14430,14158,14124,14393,13732,14556,13410,14702,12996,14814,12596,14891,12291,14937,11834,14957,11489,14958,11194,14943,10803,14921,10506,14893,10278,14858,9960,14484,14039,14487,14025,14499,13941,14524,13740,14574,13468,14654,13106,14743,12678,14818,12344,14867,11893,14889,11509,14893,11180,14881,10751,14852,10428,14812,10128,14765,9754,14712,9466,14764,13480,14764,13475,14766,13440,14766,13347,14769,13070,14786,12713,14816,12387,14844,11957,14860,11549,14868,11215,14855,10751,14825,10403,14782,10044,14729,9651,14666,9352,14599,9029,14967,12835,14966,12831,14963,12804,14954,12723,14936,12564,14917,12347,14900,11958,14886,11569,14878,11247,14859,10765,14828,10401,14784,10011,14727,9600,14660,9289,14586,8893,14508,8533,15111,12234,15110,12234,15104,12216,15092,12156,15067,12010,15028,11776,14981,11500,14942,11205,14902,10752,14861,10393,14812,9991,14752,9570,14682,9252,14603,8808,14519,8445,14431,8145,15209,11449,15208,11451,15202,11451,15190,11438,15163,11384,15117,11274,15055,10979,14994,10648,14932,10343,14871,9936,14803,9532,14729,9218,14645,8742,14556,8381,14461,8020,14365,7603,15273,10603,15272,10607,15267,10619,15256,10631,15231,10614,15182,10535,15118,10389,15042,10167,14963,9787,14883,9447,14800,9115,14710,8665,14615,8318,14514,7911,14411,7507,14279,7198,15314,9675,15313,9683,15309,9712,15298,9759,15277,9797,15229,9773,15166,9668,15084,9487,14995,9274,14898,8910,14800,8539,14697,8234,14590,7790,14479,7409,14367,7067,14178,6621,15337,8619,15337,8631,15333,8677,15325,8769,15305,8871,15264,8940,15202,8909,15119,8775,15022,8565,14916,8328,14804,8009,14688,7614,14569,7287,14448,6888,14321,6483,14088,6171,15350,7402,15350,7419,15347,7480,15340,7613,15322,7804,15287,7973,15229,8057,15148,8012,15046,7846,14933,7611,14810,7357,14682,7069,14552,6656,14421,6316,14251,5948,14007,5528,15356,5942,15356,5977,15353,6119,15348,6294,15332,6551,15302,6824,15249,7044,15171,7122,15070,7050,14949,6861,14818,6611,14679,6349,14538,6067,14398,5651,14189,5311,13935,4958,15359,4123,15359,4153,15356,4296,15353,4646,15338,5160,15311,5508,15263,5829,15188,6042,15088,6094,14966,6001,14826,5796,14678,5543,14527,5287,14377,4985,14133,4586,13869,4257,15360,1563,15360,1642,15358,2076,15354,2636,15341,3350,15317,4019,15273,4429,15203,4732,15105,4911,14981,4932,14836,4818,14679,4621,14517,4386,14359,4156,14083,3795,13808,3437,15360,122,15360,137,15358,285,15355,636,15344,1274,15322,2177,15281,2765,15215,3223,15120,3451,14995,3569,14846,3567,14681,3466,14511,3305,14344,3121,14037,2800,13753,2467,15360,0,15360,1,15359,21,15355,89,15346,253,15325,479,15287,796,15225,1148,15133,1492,15008,1749,14856,1882,14685,1886,14506,1783,14324,1608,13996,1398,13702,1183]);var J_=.91,$_=2e4,Xc={azimuth:30,elevation:25,roll:0,fov:35};function K_(n,t,e=0){let i=Te.degToRad(n),r=Te.degToRad(t),s=new st(Math.cos(i),0,-Math.sin(i)),a=new st(-Math.sin(i)*Math.cos(r),-Math.sin(r),-Math.cos(i)*Math.cos(r)),o=new st().crossVectors(s,a);if(!e)return{right:s,up:o,forward:a};let[h,l]=[Math.cos(Te.degToRad(e)),Math.sin(Te.degToRad(e))];return{right:s.clone().multiplyScalar(h).addScaledVector(o,-l),up:o.clone().multiplyScalar(h).addScaledVector(s,l),forward:a}}function qc(n,t){return e=>new st(e.x<0?n.x:t.x,e.y<0?n.y:t.y,e.z<0?n.z:t.z)}var ds=class{constructor(){Object.assign(this,Xc),this.distance=4,this.target=new st,this.orthographic=!1,this.aspect=1,this.floor=-1,this.perspectiveCamera=new Zi(Xc.fov,1,.01,1e3),this.orthographicCamera=new Ji}get camera(){return this.orthographic?this.orthographicCamera:this.perspectiveCamera}get axes(){return K_(this.azimuth,this.elevation,this.roll)}get tangent(){return Math.tan(Te.degToRad(this.fov)/2)}saved(){let{azimuth:t,elevation:e,roll:i,fov:r,orthographic:s,distance:a,target:o}=this;return{azimuth:t,elevation:e,roll:i,fov:r,orthographic:s,distance:a,target:o.toArray()}}take({target:t,...e}){Object.assign(this,e),this.target.fromArray(t)}lengthOfPixel(t,e){let i=this.orthographic?this.distance:this.camera.position.distanceTo(new st(...t));return 2*this.tangent*i/e}apply(){let{right:t,up:e,forward:i}=this.axes,{camera:r}=this;r.position.copy(this.target).addScaledVector(i,-this.distance),r.matrix.makeBasis(t,e,i.clone().negate()),r.quaternion.setFromRotationMatrix(r.matrix);let s=r.position.length(),a=this.tangent*(Math.abs(e.y)+this.aspect*Math.abs(t.y))-i.y,o=a>0?Math.max(r.position.y-this.floor,0)/a:1/0;if(r.near=Math.max(.005*this.distance,Math.min(.9*(s-1.9),.9*o),1e-5),r.far=s+$_,this.orthographic){let h=this.tangent*this.distance;Object.assign(r,{left:-h*this.aspect,right:h*this.aspect,top:h,bottom:-h}),r.near=-s-3,r.far=s+6}else r.fov=this.fov,r.aspect=this.aspect;r.updateProjectionMatrix(),r.updateMatrixWorld(!0)}frame(t){let{right:e,up:i,forward:r}=this.axes,s=p=>t(p).dot(p),[a,o]=[-1,1].map(p=>new st(...[0,1,2].map(m=>t(new st().setComponent(m,p)).getComponent(m)))),h=new st().addVectors(a,o).multiplyScalar(.5),l=Math.max(...o.clone().sub(a).toArray()),c=this.tangent*J_,u=(p,m)=>this.orthographic?(s(p)+s(p.clone().negate()))/2/m:[1,-1].reduce((g,_)=>g+s(p.clone().multiplyScalar(_/m).sub(r))+h.dot(r),0)/2,d=Math.max(u(e,c*this.aspect),u(i,c)),f=s(r.clone().negate())+h.dot(r);this.distance=Math.max(d,.001*l,this.orthographic?0:f+1e-5*l)||1,this.target.copy(h);for(let p of[e,i])this.target.addScaledVector(p,this.middle(t,p,r,h))}holds(t){let{right:e,up:i,forward:r}=this.axes,s=this.orthographic?this.target:this.camera.position;return[[e,this.tangent*this.aspect],[i,this.tangent]].every(([a,o])=>[1,-1].every(h=>{let l=a.clone().multiplyScalar(h).addScaledVector(r,this.orthographic?0:-o);return t(l).sub(s).dot(l)<=(this.orthographic?o*this.distance:0)}))}middle(t,e,i,r){let s=h=>this.orthographic?1:Math.max(h.sub(r).dot(i)+this.distance,1e-9),[a,o]=[0,0];for(let h=0;h<20;h+=1){let[l,c]=[1,-1].map(g=>t(e.clone().multiplyScalar(g).addScaledVector(i,this.orthographic?0:-a))),[u,d]=[l,c].map(g=>g.dot(e)-r.dot(e)),[f,p]=[l,c].map(g=>s(g.clone()));o=(u*p+d*f)/(f+p);let m=(u-d)/(f+p);if(Math.abs(m-a)<=1e-9*Math.abs(m))break;a=m}return o}text({center:t,scale:e}){let i=this.target.toArray().map((a,o)=>a/e+t[o]),r=a=>String(Number(a.toPrecision(6))),s=[`azimuth=${r(Q_(this.azimuth))}`,`elevation=${r(this.elevation)}`,...this.roll?[`roll=${r(this.roll)}`]:[],`distance=${r(this.distance/e)}`,`fov=${r(this.fov)}`,`target=${i.map(r).join(":")}`];return(this.orthographic?[...s,"orthographic"]:s).join(",")}json({center:t,scale:e},i,r){let{right:s,up:a,forward:o}=this.axes,h=this.orthographic?4:0,l=this.camera.position.clone().addScaledVector(o,-h).toArray().map((f,p)=>f/e+t[p]),c=a.clone().negate(),u=f=>[...f.toArray(),-(f.x*l[0]+f.y*l[1]+f.z*l[2])],d=this.orthographic?r/(2*this.tangent*this.distance/e):r/(2*this.tangent);return{format:"scenelang-camera",version:1,width:i,height:r,projection:this.orthographic?"orthographic":"perspective",K:[[d,0,i/2],[0,d,r/2],[0,0,1]],world_to_camera:[u(s),u(c),u(o),[0,0,0,1]],axes:"camera: x right, y down, z forward; world: x right, y up, z towards the viewer; pixel centers at halves",aperture:0,focus:this.distance/e}}};function Q_(n){return Te.euclideanModulo(n+180,360)-180}function Yc(n,t,e,i=()=>!1){let r=new Map,s=(l,c)=>{t.azimuth-=l*.4,t.elevation=Te.clamp(t.elevation+c*.4,-90,90)},a=(l,c)=>{let{right:u,up:d}=t.axes,f=2*t.tangent*t.distance/n.clientHeight;t.target.addScaledVector(u,-l*f).addScaledVector(d,c*f)},o=l=>{t.distance=Te.clamp(t.distance*l,.001,500)},h=()=>{let[l,c]=[...r.values()];return Math.hypot(l.x-c.x,l.y-c.y)};n.addEventListener("pointerdown",l=>{i()||(n.setPointerCapture(l.pointerId),r.set(l.pointerId,{x:l.clientX,y:l.clientY}))}),n.addEventListener("pointermove",l=>{i()&&r.clear();let c=r.get(l.pointerId);if(c===void 0)return;let[u,d]=[l.clientX-c.x,l.clientY-c.y],f=r.size===2?h():0;r.set(l.pointerId,{x:l.clientX,y:l.clientY});let p=r.size===1&&!(l.buttons&6)&&!l.shiftKey;p?s(u,d):r.size===2?(a(u/2,d/2),o(f/Math.max(h(),1))):a(u,d),e(p)});for(let l of["pointerup","pointercancel"])n.addEventListener(l,c=>r.delete(c.pointerId));n.addEventListener("contextmenu",l=>l.preventDefault()),n.addEventListener("wheel",l=>{l.preventDefault(),o(Math.exp(Te.clamp(l.deltaY,-200,200)*.0012)),e(!1)},{passive:!1}),n.addEventListener("keydown",l=>{let c={ArrowLeft:[20,0],ArrowRight:[-20,0],ArrowUp:[0,20],ArrowDown:[0,-20]}[l.key],u=c!==void 0&&!l.shiftKey;if(u)s(...c);else if(c)a(...c);else if(l.key==="+"||l.key==="=")o(.9);else if(l.key==="-")o(1/.9);else return;l.preventDefault(),e(u)})}function Ue(n){return document.getElementById(n)}var j_=new Intl.NumberFormat("en-US"),f3=new Intl.NumberFormat("en-US",{notation:"compact",maximumSignificantDigits:3});function Fo(n){return n<=Number.MAX_SAFE_INTEGER?j_.format(n):n.toExponential(2)}var ps=class{constructor({bar:t,play:e,slider:i,label:r,rate:s},a,o){Object.assign(this,{bar:t,play:e,slider:i,label:r,rate:s,show:a,paused:o,frames:1,frame:0,playing:!1}),e.addEventListener("click",()=>this.toggle()),i.addEventListener("input",()=>this.go(Number(i.value)))}take(t){this.frames=t,this.bar.hidden=t<2,t<2&&this.pause(),this.slider.max=String(t-1),this.frame=Math.min(this.frame,t-1),this.write()}go(t){this.frame=(t%this.frames+this.frames)%this.frames,this.write(),this.show(this.frame)}write(){this.slider.value=String(this.frame),this.slider.setAttribute("aria-valuetext",`frame ${this.frame}`),this.label.textContent=`${Fo(this.frame)} / ${Fo(this.frames-1)}`}toggle(){this.playing?this.pause():this.frames>1&&this.start()}pause(){this.playing&&(this.playing=!1,this.play.textContent="Play",this.paused())}start(){this.playing=!0,this.play.textContent="Pause";let t=performance.now(),e=i=>{if(!this.playing)return;let r=1e3/Number(this.rate.value);i>=t&&(t=Math.max(t+r,i-r),this.go(this.frame+1)),requestAnimationFrame(e)};requestAnimationFrame(e)}};async function Zc(n){let t=JSON.parse(n),e=Uint8Array.from(atob(t.cells),l=>l.charCodeAt(0)),i=new Blob([e]).stream().pipeThrough(new DecompressionStream("gzip")),r=await new Response(i).arrayBuffer(),s=0,a=(l,c)=>{let u=new l(r,s,c);return s+=4*c,u},o=t.counts.map(l=>({count:l,cells:[a(Int32Array,l),a(Int32Array,l),a(Int32Array,l)],states:a(Uint32Array,l),around:a(Uint32Array,l)}));if(s!==r.byteLength||r.byteLength!==20*t.counts.reduce((l,c)=>l+c,0))throw new Error("the build is damaged");let h=Object.keys(t.frames).map(Number).sort((l,c)=>l-c);return{...t,distinct:o,numbers:h}}async function Jc(n){let t=new Image;return t.src=n.image,await t.decode(),t}var tx=[[0,-1,0],[0,1,0],[0,0,-1],[0,0,1],[-1,0,0],[1,0,0]],$c=[.4,.6,.8,1];function Qc(n,t,e){let i=[],r=0;for(;r<t.count;){let s=Kc(t,r),a=r+1;for(;a<t.count&&ex(s,Kc(t,a));)a+=1;i.push(nx(n,t,e,s.map(o=>o*32),r,a)),r=a}return i}function jc(n,t){for(let{solid:e,clear:i}of t)for(let{buffer:r}of[...e,...i])n.deleteBuffer(r)}function Kc({cells:n},t){return n.map(e=>Math.floor(e[t]/32))}function ex(n,t){return n[0]===t[0]&&n[1]===t[1]&&n[2]===t[2]}function nx(n,t,e,i,r,s){let a=new ms,o=new ms;for(let h=r;h<s;h+=1){let l=t.around[h],c=t.cells.map((u,d)=>u[h]-i[d]);for(let u of e.of(t.states[h],l>>>26,rx(l)))(u.isClear?o:a).add(u,c,l)}return{corner:i,solid:a.parts(n,!1),clear:o.parts(n,!0)}}var ms=class{constructor(){this.floats=new Float32Array(1024),this.words=new Uint32Array(this.floats.buffer),this.used=0}add(t,[e,i,r],s){this.used+20>this.floats.length&&this.grow();let{floats:a,words:o}=this,{positions:h,places:l,axis:c,color:u}=t;for(let d=0;d<4;d+=1){let[f,p,m]=[h[3*d],h[3*d+1],h[3*d+2]],g=c===null?1:ix(f,p,m,c,s);a[this.used]=f+e,a[this.used+1]=p+i,a[this.used+2]=m+r,o[this.used+3]=Math.round(65535*l[2*d])|Math.round(65535*l[2*d+1])<<16,o[this.used+4]=Oo(u[0]*g)|Oo(u[1]*g)<<8|Oo(u[2]*g)<<16|255<<24,this.used+=5}}grow(){let t=new Float32Array(2*this.floats.length);t.set(this.floats),this.floats=t,this.words=new Uint32Array(t.buffer)}parts(t,e){let i=[];for(let s=0;s<this.used;s+=327680){let a=this.floats.slice(s,Math.min(s+327680,this.used)),o=t.createBuffer();t.bindBuffer(t.ARRAY_BUFFER,o),t.bufferData(t.ARRAY_BUFFER,a,t.STATIC_DRAW),i.push({buffer:o,count:a.length/20,data:e?a:null})}return i}},ui={stride:20,place:12,color:16,words:5,most:16384};function Oo(n){return Math.max(0,Math.min(255,Math.round(255*n)))}function ix(n,t,e,i,r){let s=[n,t,e],a=i.findIndex(m=>m!==0);if(Math.abs(s[a]-(i[a]>0?1:0))>.01)return 1;let[o,h]=[0,1,2].filter(m=>m!==a),l=(m,g)=>{let _=[...i];return _[o]=m,_[h]=g,th(_,r)},[c,u]=[Math.sign(s[o]-.5),Math.sign(s[h]-.5)],d=c!==0&&l(c,0),f=u!==0&&l(0,u);if(d&&f)return $c[0];let p=c!==0&&u!==0&&l(c,u);return $c[3-d-f-p]}function rx(n){return tx.reduce((t,e,i)=>t|th(e,n)<<i,0)}function th([n,t,e],i){let r=9*(n+1)+3*(t+1)+(e+1);return i>>>(r>13?r-1:r)&1}function eh(n,t){let e=n.world_to_camera.slice(0,3),i=e.map(c=>c.slice(0,3)),r=e.map(c=>c[3]+c[0]*t[0]+c[1]*t[1]+c[2]*t[2]),s=[0,1,2].map(c=>-(i[0][c]*r[0]+i[1][c]*r[1]+i[2][c]*r[2])),[[a,,o],[,h,l]]=n.K;return{axes:i,eye:s,fx:a,fy:h,cx:o,cy:l,width:n.width,height:n.height,isParallel:n.projection==="orthographic"}}function nh(n,t){return n[0]*t[0]+n[1]*t[1]+n[2]*t[2]}function gs(n,t){return nh(n.axes[2],t.map((e,i)=>e-n.eye[i]))}function ih(n,t,e){let i=[];for(let o of[t[0],e[0]])for(let h of[t[1],e[1]])for(let l of[t[2],e[2]])i.push(gs(n,[o,h,l]));let r=2,s=Math.max(Math.max(...i)+r,1),a=Math.min(...i)-r;return n.isParallel?[a,s]:[Math.max(a,s*1e-4,.01),s]}function Bo(n,t,[e,i]){let{axes:r,fx:s,fy:a,cx:o,cy:h,width:l,height:c}=n,[u,d,f]=r.map(x=>[...x,nh(x,t.map((w,b)=>w-n.eye[b]))]),[p,m]=[2*o/l-1,1-2*h/c],g=n.isParallel?[0,0,0,1]:f,[_,y]=n.isParallel?[2/(i-e),-(i+e)/(i-e)]:[(i+e)/(i-e),-2*i*e/(i-e)],v=[u.map((x,w)=>2*s/l*x+p*g[w]),d.map((x,w)=>-2*a/c*x+m*g[w]),f.map((x,w)=>_*x+(w===3?y:0)),g];return new Float32Array([0,1,2,3].flatMap(x=>v.map(w=>w[x])))}var rh={vertex:`#version 300 es
    in vec3 position; in vec2 place; in vec4 color;
    uniform mat4 matrix;
    centroid out vec2 vPlace; out vec3 vColor; // never a place outside of the face
    void main() { gl_Position = matrix * vec4(position, 1.0); vPlace = place; vColor = color.rgb; }`,fragment:`#version 300 es
    precision highp float;
    centroid in vec2 vPlace; in vec3 vColor;
    uniform sampler2D atlas; uniform vec3 light; uniform float least;
    out vec4 result;
    void main() {
      vec4 texel = texture(atlas, vPlace);
      if (texel.a < least) discard;
      result = vec4(min(texel.rgb * vColor * light, 1.0), texel.a);
    }`},sh={vertex:`#version 300 es
    const vec2 corners[3] = vec2[3](vec2(-1.0, -1.0), vec2(3.0, -1.0), vec2(-1.0, 3.0));
    void main() { gl_Position = vec4(corners[gl_VertexID], 0.0, 1.0); }`,fragment:`#version 300 es
    precision highp float;
    uniform vec2 size; uniform vec4 lens; uniform bool isParallel; uniform float unit;
    uniform vec3 eye; uniform vec3 right; uniform vec3 down; uniform vec3 forward;
    uniform vec3 backdrop; uniform bool hasGround; uniform float height; uniform vec3 ground; uniform vec3 other; uniform float checker;
    uniform sampler2D shadow; uniform vec3 shadowPlace;
    out vec4 result;
    void main() {
      vec2 pixel = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y);
      vec2 q = (pixel - lens.zw) / lens.xy;
      vec3 start = isParallel ? eye + unit * (q.x * right + q.y * down) : eye;
      vec3 ray = isParallel ? forward : q.x * right + q.y * down + forward;
      float t = (height - start.y) / ray.y;
      result = vec4(backdrop, 1.0);
      if (!hasGround || t <= 0.0 || abs(ray.y) < 1e-9) return;
      vec2 hit = start.xz + t * ray.xz;
      vec2 at = (hit - shadowPlace.xy) / shadowPlace.z;
      bool isInside = all(greaterThan(at, vec2(0.0))) && all(lessThan(at, vec2(1.0)));
      float dark = isInside ? texture(shadow, at).r : 0.0;
      vec2 square = floor(hit / checker);
      vec3 color = mod(square.x + square.y, 2.0) == 0.0 ? ground : other;
      result = vec4(color * pow(1.0 - dark, 1.0 / 2.2), 1.0);
    }`},$i=class{constructor(t,{vertex:e,fragment:i}){this.gl=t,this.program=t.createProgram();for(let[r,s]of[[t.VERTEX_SHADER,e],[t.FRAGMENT_SHADER,i]]){let a=t.createShader(r);t.shaderSource(a,s),t.compileShader(a),t.attachShader(this.program,a)}if(t.linkProgram(this.program),!t.getProgramParameter(this.program,t.LINK_STATUS))throw new Error(`WebGL: ${t.getProgramInfoLog(this.program)}`)}at(t){return this.gl.getUniformLocation(this.program,t)}attribute(t){return this.gl.getAttribLocation(this.program,t)}};function oh(n,t,e,i){let r=Math.max(e[0]-t[0],e[2]-t[2]),s=1.5*r+12,a=[(t[0]+e[0]-s)/2,(t[2]+e[2]-s)/2],o=s/256,h=new Float32Array(256*256);for(let c=0;c<n.count;c+=1){let u=1-(n.cells[1][c]-i)/8;u>0&&sx(h,n.cells[0][c]-a[0],n.cells[2][c]-a[1],o,Math.min(u,1))}let l=Math.max(1,Math.round(Math.max(1.2,.04*r)/o));for(let c=0;c<3;c+=1)h=ah(ah(h,l,1,256),l,256,1);return{side:256,corner:a,size:s,values:Uint8Array.from(h,c=>Math.round(255*.6*c))}}function sx(n,t,e,i,r){let[s,a]=[Math.floor(t/i),Math.max(Math.floor(t/i),Math.ceil((t+1)/i)-1)],[o,h]=[Math.floor(e/i),Math.max(Math.floor(e/i),Math.ceil((e+1)/i)-1)];for(let l=Math.max(o,0);l<=Math.min(h,255);l+=1)for(let c=Math.max(s,0);c<=Math.min(a,255);c+=1)n[l*256+c]=Math.max(n[l*256+c],r)}function ah(n,t,e,i){let r=new Float32Array(n.length);for(let s=0;s<256;s+=1){let a=0,o=h=>h<0||h>=256?0:n[s*i+h*e];for(let h=-t;h<t;h+=1)a+=o(h);for(let h=0;h<256;h+=1)a+=o(h+t)-o(h-t-1),r[s*i+h*e]=a/(2*t+1)}return r}var ax=3e6,ox=.25,_s=class{constructor(t,e,i,r){Object.assign(this,{canvas:t,build:e,quads:r,frames:new Map});let s=t.getContext("webgl2",{antialias:!0,alpha:!1,preserveDrawingBuffer:!0});if(!s)throw new Error("this browser has no WebGL 2");this.gl=s,this.blocks=new $i(s,rh),this.behind=new $i(s,sh),this.empty=s.createVertexArray(),this.atlas=this.texture(s.NEAREST),s.texImage2D(s.TEXTURE_2D,0,s.RGBA,s.RGBA,s.UNSIGNED_BYTE,i),this.indices=s.createBuffer(),s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,this.indices),s.bufferData(s.ELEMENT_ARRAY_BUFFER,lh(Array.from({length:ui.most},(a,o)=>o)),s.STATIC_DRAW),this.sorted=s.createBuffer()}texture(t){let{gl:e}=this,i=e.createTexture();e.bindTexture(e.TEXTURE_2D,i);for(let r of[e.TEXTURE_MIN_FILTER,e.TEXTURE_MAG_FILTER])e.texParameteri(e.TEXTURE_2D,r,t);for(let r of[e.TEXTURE_WRAP_S,e.TEXTURE_WRAP_T])e.texParameteri(e.TEXTURE_2D,r,e.CLAMP_TO_EDGE);return i}frame(t){let e=this.build.frames[t];if(!this.frames.has(e)){let i=this.build.distinct[e],r=i.count;for(let h of this.frames.values())r+=h.count;r>ax&&this.forget();let{box:s,studio:a}=this.build,o=a.height/s.scale+s.center[1];this.frames.set(e,{count:i.count,chunks:Qc(this.gl,i,this.quads),shadow:this.shade(oh(i,s.low,s.high,o))})}return this.frames.get(e)}forget(){for(let{chunks:t,shadow:e}of this.frames.values())jc(this.gl,t),this.gl.deleteTexture(e.texture);this.frames.clear()}shade({side:t,corner:e,size:i,values:r}){let{gl:s}=this,a=this.texture(s.LINEAR);return s.texImage2D(s.TEXTURE_2D,0,s.R8,t,t,0,s.RED,s.UNSIGNED_BYTE,r),{texture:a,corner:e,size:i}}draw(t,e){let{gl:i,canvas:r,build:s}=this;if(i.drawingBufferWidth!==r.width||i.drawingBufferHeight!==r.height)throw new Error("the picture is too large for this browser");let{chunks:a,shadow:o}=this.frame(t),h=eh(e,s.corner);i.viewport(0,0,r.width,r.height),i.clear(i.DEPTH_BUFFER_BIT|i.COLOR_BUFFER_BIT),this.drawBehind(h,o),i.useProgram(this.blocks.program),i.bindVertexArray(null),i.enable(i.DEPTH_TEST),i.enable(i.CULL_FACE),i.enable(i.BLEND),i.blendFunc(i.SRC_ALPHA,i.ONE_MINUS_SRC_ALPHA),i.bindTexture(i.TEXTURE_2D,this.atlas),i.uniform3fv(this.blocks.at("light"),s.studio.light.map(c=>Math.max(c,0)**(1/2.2)));let l=ih(h,s.box.low,s.box.high);i.uniform1f(this.blocks.at("least"),.5);for(let{corner:c,solid:u}of a)for(let d of u)this.drawPart(d,this.indices,Bo(h,c,l));i.uniform1f(this.blocks.at("least"),.02),i.depthMask(!1);for(let{corner:c,clear:u}of lx(a,h))for(let d of u)this.drawClear(d,c,h,l);i.depthMask(!0)}drawClear(t,e,i,r){let{gl:s}=this,{words:a}=ui,o=new Float32Array(t.count);for(let l=0;l<t.count;l+=1){let c=4*a*l;o[l]=gs(i,[0,1,2].map(u=>e[u]+(t.data[c+u]+t.data[c+2*a+u])/2))}let h=Array.from(o.keys()).sort((l,c)=>o[c]-o[l]);s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,this.sorted),s.bufferData(s.ELEMENT_ARRAY_BUFFER,lh(h),s.DYNAMIC_DRAW),this.drawPart(t,this.sorted,Bo(i,e,r))}drawPart({buffer:t,count:e},i,r){let{gl:s,blocks:a}=this;s.bindBuffer(s.ARRAY_BUFFER,t),s.bindBuffer(s.ELEMENT_ARRAY_BUFFER,i);for(let[o,h,l,c,u]of[["position",3,s.FLOAT,!1,0],["place",2,s.UNSIGNED_SHORT,!0,ui.place],["color",4,s.UNSIGNED_BYTE,!0,ui.color]]){let d=a.attribute(o);s.enableVertexAttribArray(d),s.vertexAttribPointer(d,h,l,c,ui.stride,u)}s.uniformMatrix4fv(a.at("matrix"),!1,r),s.drawElements(s.TRIANGLES,6*e,s.UNSIGNED_SHORT,0)}drawBehind(t,e){let{gl:i,behind:r,canvas:s}=this,{box:a,studio:o}=this.build,h=f=>f.map((p,m)=>(p-a.center[m])*a.scale),l=h(t.eye),c=s.height/t.height;i.useProgram(r.program),i.bindVertexArray(this.empty),i.disable(i.DEPTH_TEST),i.disable(i.CULL_FACE),i.disable(i.BLEND),i.bindTexture(i.TEXTURE_2D,e.texture),i.uniform2f(r.at("size"),s.width,s.height),i.uniform4f(r.at("lens"),t.fx*c,t.fy*c,t.cx*c,t.cy*c),i.uniform1i(r.at("isParallel"),Number(t.isParallel)),i.uniform1f(r.at("unit"),a.scale),i.uniform3fv(r.at("eye"),l);for(let[f,p]of["right","down","forward"].entries())i.uniform3fv(r.at(p),t.axes[f]);i.uniform3fv(r.at("backdrop"),o.backdrop),i.uniform1i(r.at("hasGround"),+(o.ground!==null&&l[1]>o.height+.001)),i.uniform1f(r.at("height"),o.height),i.uniform3fv(r.at("ground"),o.ground?.[0]??o.backdrop),i.uniform3fv(r.at("other"),o.ground?.[1]??o.backdrop),i.uniform1f(r.at("checker"),ox);let[u,,d]=h([e.corner[0],0,e.corner[1]]);i.uniform3f(r.at("shadowPlace"),u,d,e.size*a.scale),i.drawArrays(i.TRIANGLES,0,3)}};function lh(n){let t=new Uint16Array(6*n.length);return n.forEach((e,i)=>t.set([0,1,2,0,2,3].map(r=>4*e+r),6*i)),t}function lx(n,t){let e=i=>gs(t,i.corner.map(r=>r+16));return n.filter(({clear:i})=>i.length).sort((i,r)=>e(r)-e(i))}var M;(function(n){function t(u){return typeof u=="number"?u:void 0}n.readNumber=t;function e(u){return typeof u=="number"?Math.floor(u):void 0}n.readInt=e;function i(u){return typeof u=="string"?u:void 0}n.readString=i;function r(u){return typeof u=="boolean"?u:void 0}n.readBoolean=r;function s(u){return typeof u=="object"&&u!==null&&!Array.isArray(u)?u:void 0}n.readObject=s;function a(u,d){if(Array.isArray(u))return d?u.map(f=>d(f)):u}n.readArray=a;function o(u,d){if(Array.isArray(u))return[0,1].map((f=>d(u[f])))}n.readPair=o;function h(u,d){let f=s(u)??{};return Object.fromEntries(Object.entries(f).map(([p,m])=>[p,d(m)]))}n.readMap=h;function l(u,d,f){let p=d(u);return p?f(p):void 0}n.compose=l;function c(u,d){return typeof u!="string"?d[0]:d.includes(u)?u:d[0]}n.readEnum=c})(M=M||(M={}));var Z;(function(n){function t(r){let s=M.readNumber(r);if(s)return i(s);let a=M.readArray(r,o=>M.readNumber(o)??0);if(!(a===void 0||a.length!==3))return a}n.fromJson=t;function e(r){if(r.isNumber())return i(r.getAsNumber());if(!r.isListOrArray())return;let s=r.getItems();if(!(s.length<3))return s.map(a=>a.getAsNumber())}n.fromNbt=e;function i(r){let s=r>>16&255,a=r>>8&255,o=r&255;return[s/255,a/255,o/255]}n.intToRgb=i})(Z=Z||(Z={}));var xe=class n{source;cursor;constructor(t){this.source=t,this.cursor=0}get remainingLength(){return this.source.length-this.cursor}get totalLength(){return this.source.length}getRead(t=0){return this.source.substring(t,this.cursor)}getRemaining(){return this.source.substring(this.cursor)}canRead(t=1){return this.cursor+t<=this.source.length}peek(t=0){return this.source.charAt(this.cursor+t)}read(){return this.source.charAt(this.cursor++)}skip(){this.cursor+=1}skipWhitespace(){for(;this.canRead()&&n.isWhitespace(this.peek());)this.skip()}expect(t,e=!1){if(e&&this.skipWhitespace(),!this.canRead()||this.peek()!==t)throw this.createError(`Expected '${t}'`);this.skip()}readInt(){let t=this.cursor;for(;this.canRead()&&n.isAllowedInNumber(this.peek());)this.skip();let e=this.getRead(t);if(e.length===0)throw this.createError("Expected integer");try{let i=Number(e);if(isNaN(i)||!Number.isInteger(i))throw new Error;return i}catch{throw this.cursor=t,this.createError(`Invalid integer '${e}'`)}}readFloat(){let t=this.cursor;for(;this.canRead()&&n.isAllowedInNumber(this.peek());)this.skip();let e=this.getRead(t);if(e.length===0)throw this.createError("Expected float");try{let i=Number(e);if(isNaN(i))throw new Error;return i}catch{throw this.cursor=t,this.createError(`Invalid float '${e}'`)}}readUnquotedString(){let t=this.cursor;for(;this.canRead()&&n.isAllowedInUnquotedString(this.peek());)this.skip();return this.getRead(t)}readQuotedString(){if(!this.canRead())return"";let t=this.peek();if(!n.isQuotedStringStart(t))throw this.createError("Expected quote to start a string");return this.skip(),this.readStringUntil(t)}readString(){if(!this.canRead())return"";let t=this.peek();return n.isQuotedStringStart(t)?(this.skip(),this.readStringUntil(t)):this.readUnquotedString()}readStringUntil(t){let e=[],i=!1;for(;this.canRead();){let r=this.read();if(i)if(r===t||r==="\\")e.push(r),i=!1;else throw this.cursor-=1,this.createError(`Invalid escape sequence '${r}' in quoted string`);else if(r==="\\")i=!0;else{if(r===t)return e.join("");e.push(r)}}throw this.createError("Unclosed quoted string")}readBoolean(){let t=this.cursor,e=this.readUnquotedString();if(e.length===0)throw this.createError("Expected bool");if(e==="true")return!0;if(e==="false")return!1;throw this.cursor=t,this.createError(`Invalid bool, expected true or false but found '${e}'`)}static isAllowedInNumber(t){return t>="0"&&t<="9"||t==="."||t==="-"}static isAllowedInUnquotedString(t){return t>="0"&&t<="9"||t>="A"&&t<="Z"||t>="a"&&t<="z"||t==="_"||t==="-"||t==="."||t==="+"}static isQuotedStringStart(t){return t==="'"||t==='"'}static isWhitespace(t){return t===" "||t==="	"||t===`
`||t==="\r"}createError(t){let e=Math.min(this.source.length,this.cursor),i=(e>10?"...":"")+this.source.substring(Math.max(0,e-10),e);return new Error(`${t} at position ${this.cursor}: ${i}<--[HERE]`)}};function Ki(n,t,e){let i=n.get(t);if(i!==void 0)return i;let r=e(t);return n.set(t,r),r}var X=class n{min;max;static NaI=new n(NaN,NaN);static INFINITE=new n(-1/0,1/0);constructor(t,e){this.min=t,this.max=e}static of(t,e){return e<t||isNaN(t)||isNaN(e)?n.NaI:t===-1/0&&e===1/0?n.INFINITE:new n(t,e)}static ofSymmetric(t){return n.of(-t,t)}static ofExact(t){return n.of(t,t)}static between(t,e){return isNaN(t)&&isNaN(e)?n.NaI:isNaN(t)?n.ofExact(e):isNaN(e)?n.ofExact(t):n.of(Math.min(t,e),Math.max(t,e))}static encapsulating(...t){let e=1/0,i=-1/0;for(let r of t)r.isNaI()||(e=Math.min(e,r.min),i=Math.max(i,r.max));return i<e?n.NaI:n.of(e,i)}static add(t,e){return n.of(t.min+e.min,t.max+e.max)}static sub(t,e){return n.of(t.min-e.min,t.max-e.max)}static mul(t,e){if(t.isNaI()||e.isNaI())return n.NaI;let i=n.mulBound(t.min,e.min),r=n.mulBound(t.min,e.max),s=n.mulBound(t.max,e.min),a=n.mulBound(t.max,e.max);return n.of(Math.min(i,r,s,a),Math.max(i,r,s,a))}static mulBound(t,e){return t===0||e==0?0:t*e}static reciprocal(t){return t.isNaI()||t.min===0&&t.max===0?n.NaI:t.contains(0)?n.of(1/t.max,1/t.min):t.max===0?n.of(-1/0,1/t.min):t.min===0?n.of(1/t.max,1/0):n.INFINITE}static div(t,e){return n.mul(t,n.reciprocal(e))}static min(t,e){return t.isNaI()||e.isNaI()?n.NaI:n.of(Math.min(t.min,t.min),Math.min(t.max,e.max))}static max(t,e){return t.isNaI()||e.isNaI()?n.NaI:n.of(Math.max(t.min,t.min),Math.max(t.max,e.max))}static clamp(t,e,i){return e>i||t.isNaI()?n.NaI:t.min>=i?n.ofExact(i):t.max<=e?n.ofExact(e):n.of(Math.max(t.min,e),Math.min(t.max,i))}static abs(t){if(t.isNaI())return n.NaI;let e=Math.max(Math.abs(t.min),Math.abs(t.max));if(t.contains(0))return n.of(0,e);{let i=Math.min(Math.abs(t.min),Math.abs(t.max));return n.of(i,e)}}static square(t){if(t.isNaI())return n.NaI;let e=Math.max(t.min*t.min,t.max*t.max);if(t.contains(0))return n.of(0,e);{let i=Math.min(t.min*t.min,t.max*t.max);return n.of(i,e)}}static pow(t,e){if(t.isNaI()||e.isNaI())return n.NaI;if(t.min==t.max)return n.powNum(t.min,e);let i=n.encapsulating(n.powNum(t.min,e),n.powNum(t.max,e));return t.contains(0)&&(t.max>0&&(i=n.encapsulating(i,n.powNum(0,e))),t.min<0&&(i=n.encapsulating(i,n.powNum(-0,e)))),i}static powNum(t,e){return n.INFINITE}static log(t){if(t.max<0)return n.NaI;let e=n.max(t,n.ofExact(0));return n.mapMonotonic(e,Math.log)}static mapMonotonic(t,e){if(t.isNaI())return n.NaI;let i=e(t.min),r=e(t.max);return n.of(Math.min(i,r),Math.max(i,r))}static lerp(t,e,i){return t.isNaI()||e.isNaI()||i.isNaI()?n.NaI:n.encapsulating(n.lerpNums(t,e.min,i.min),n.lerpNums(t,e.max,i.min),n.lerpNums(t,e.min,i.max),n.lerpNums(t,e.max,i.max))}static lerpNums(t,e,i){if(t.isNaI()||isNaN(e)||isNaN(i))return n.NaI;if(isFinite(e)&&isFinite(i))return n.between(n.lerpFiniteBound(t.min,e,i),n.lerpFiniteBound(t.max,e,i));if(e===i)return n.ofExact(e);let r=n.lerpInfiniteBound(t.min,e,i),s=n.lerpInfiniteBound(t.max,e,i);return isNaN(r)||isNaN(s)?n.NaI:n.between(r,s)}static lerpFiniteBound(t,e,i){return e+n.mulBound(t,i-e)}static lerpInfiniteBound(t,e,i){let r=n.mulBound(1-t,e),s=n.mulBound(t,i);return isFinite(r)||isFinite(s)?r+s:t<=0?i>e?-1/0:1/0:t>=1?i>e?1/0:-1/0:NaN}static sign(t){return t.isNaI()?n.NaI:t.min===t.max?n.ofExact(Math.sign(t.min)):t.contains(0)?t.min===0?n.of(0,1):t.max===0?n.of(-1,0):n.of(-1,1):n.ofExact(t.min>0?1:-1)}contains(t){return this.min<=t&&t<=this.max}intersects(t){return this.min<=t.max&&t.min<=this.max}isNaI(){return this===n.NaI}};var cx=9223372036854776e3;function Re(n){return n*n}function Ot(n,t,e){return Math.max(t,Math.min(e,n))}function fi(n,t,e){return t+n*(e-t)}function di(n,t,e){return Math.fround(t+Math.fround(n*Math.fround(e-t)))}function ch(n,t,e,i,r,s){return fi(t,fi(n,e,i),fi(n,r,s))}function uh(n,t,e,i,r,s,a,o,h,l,c){return fi(e,ch(n,t,i,r,s,a),ch(n,t,o,h,l,c))}function xs(n,t,e){return n===0?t():n===1?e():t()+n*(e()-t())}function hh(n,t,e,i,r,s){return xs(t,()=>xs(n,e,i),()=>xs(n,r,s))}function fh(n,t,e,i,r,s,a,o,h,l,c){return xs(e,()=>hh(n,t,i,r,s,a),()=>hh(n,t,o,h,l,c))}function dh(n,t,e){return n<0?t:n>1?e:fi(n,t,e)}function hx(n,t,e){return(n-t)/(e-t)}function vs(n){return n*n*n*(n*(n*6-15)+10)}function ys(n,t,e,i,r){return fi(hx(n,t,e),i,r)}function ve(n){return Ot(Math.floor(n),-2147483648,2147483647)}function ph(n){return Ot(Math.floor(n),-9223372036854776e3,cx)}function mh(n,t,e){let i=t-n;for(;i>0;){let r=Math.floor(i/2),s=n+r;if(e(s)){i=r;continue}n=s+1,i-=r+1}return n}function Ss(n,t,e){let i=BigInt.asIntN(64,BigInt(n)*BigInt(3129871)^BigInt(e)*BigInt(116129781)^BigInt(t));return i=BigInt.asIntN(64,BigInt.asIntN(64,i*i*BigInt(42317861))+BigInt.asIntN(64,i*BigInt(11))),i>>BigInt(16)}function zo(n,t,e,i,r,s,a,o){return BigInt(n)<<BigInt(56)|BigInt(t)<<BigInt(48)|BigInt(e)<<BigInt(40)|BigInt(i)<<BigInt(32)|BigInt(r)<<BigInt(24)|BigInt(s)<<BigInt(16)|BigInt(a)<<BigInt(8)|BigInt(o)}function Ms(n,t,e){return n.nextInt(e-t+1)+t}function bs(n,t,e){return t>=e?t:n.nextInt(e-t+1)+t}function gh(n,t){for(var e=n.length;e>1;e--){let i=t.nextInt(e),r=n[i];n[i]=n[e-1],n[e-1]=r}}function _h(n){for(var t=0,e=0;t<n.length;t++)e=Math.imul(31,e)+n.charCodeAt(t)|0;return e}var Qi;(function(n){function t(r,s){if(typeof r=="number")return new e(r);let a=M.readObject(r)??{},o=new i(s(a.coordinate)),h=M.readArray(a.points,l=>M.readObject(l)??{})??[];if(h.length===0)return new e(0);for(let l of h){let c=M.readNumber(l.location)??0,u=t(l.value,s),d=M.readNumber(l.derivative)??0;o.addPoint(c,u,d)}return o}n.fromJson=t;class e{value;constructor(s){this.value=s}compute(){return this.value}range(){return X.of(this.value,this.value)}mapCoordinates(){return this}}n.Constant=e;class i{coordinate;locations;values;derivatives;constructor(s,a=[],o=[],h=[]){this.coordinate=s,this.locations=a,this.values=o,this.derivatives=h}compute(s){let a=this.coordinate.compute(s),o=mh(0,this.locations.length,v=>a<this.locations[v])-1,h=this.locations.length-1;if(o<0)return Math.fround(this.values[0].compute(s)+Math.fround(this.derivatives[0]*Math.fround(a-this.locations[0])));if(o===h)return Math.fround(this.values[h].compute(s)+Math.fround(this.derivatives[h]*Math.fround(a-this.locations[h])));let l=this.locations[o],c=this.locations[o+1],u=this.derivatives[o],d=this.derivatives[o+1],f=Math.fround(Math.fround(a-l)/Math.fround(c-l)),p=this.values[o].compute(s),m=this.values[o+1].compute(s),g=Math.fround(Math.fround(u*Math.fround(c-l))-Math.fround(m-p)),_=Math.fround(Math.fround(-d*Math.fround(c-l))+Math.fround(m-p));return Math.fround(di(f,p,m)+Math.fround(Math.fround(f*Math.fround(1-f))*di(f,g,_)))}mapCoordinates(s){return new i(s(this.coordinate),this.locations,this.values.map(a=>a.mapCoordinates(s)),this.derivatives)}addPoint(s,a,o=0){return this.locations.push(Math.fround(s)),this.values.push(typeof a=="number"?new n.Constant(Math.fround(a)):a),this.derivatives.push(Math.fround(o)),this}range(){let s=this.locations.length-1;var a=Number.POSITIVE_INFINITY,o=Number.NEGATIVE_INFINITY;let h=this.coordinate.range();if(h.isNaI())return h;if(h.min<this.locations[0]){let u=this.values[0].range(),d=i.linearExtend(u.min,this.locations,u.min,this.derivatives,0),f=i.linearExtend(u.min,this.locations,u.min,this.derivatives,0);a=Math.min(a,Math.min(d,f)),o=Math.max(o,Math.max(d,f))}if(h.max>this.locations[s]){let u=this.values[s].range(),d=i.linearExtend(u.max,this.locations,u.min,this.derivatives,s),f=i.linearExtend(u.max,this.locations,u.max,this.derivatives,s);a=Math.min(a,Math.min(d,f)),o=Math.max(o,Math.max(d,f))}let l=this.values.map(u=>u.range());for(let u of l)a=Math.min(a,u.min),o=Math.max(o,u.max);for(var c=0;c<s;++c){let u=this.locations[c],d=this.locations[c+1],f=Math.fround(d-u),p=l[c],m=l[c+1],g=this.derivatives[c],_=this.derivatives[c+1];if(g!==0||_!==0){let y=Math.fround(g*f),v=Math.fround(_*f),x=Math.min(p.min,m.min),w=Math.max(p.max,m.max),b=Math.fround(Math.fround(y-m.max)+p.min),A=Math.fround(Math.fround(y-m.min)+p.max),I=Math.fround(Math.fround(-v+m.min)-p.max),C=Math.fround(Math.fround(-v+m.max)-p.min),P=Math.min(b,I),L=Math.max(A,C);a=Math.min(a,Math.fround(x+Math.fround(.25*P))),o=Math.max(o,Math.fround(w+Math.fround(.25*L)))}}return X.of(a,o)}static linearExtend(s,a,o,h,l){let c=h[l];return c==0?o:Math.fround(o+Math.fround(c*Math.fround(s-a[l])))}}n.MultiPoint=i})(Qi=Qi||(Qi={}));var $e={};na($e,{ANGLE_ORDER:()=>ux,ARRAY_TYPE:()=>ie,EPSILON:()=>xt,RANDOM:()=>ws,equals:()=>_x,round:()=>ji,setMatrixArrayType:()=>fx,toDegree:()=>gx,toRadian:()=>mx});var xt=1e-6,ie=typeof Float32Array<"u"?Float32Array:Array,ws=Math.random,ux="zyx";function ji(n){return n>=0?Math.round(n):n%.5===0?Math.floor(n):Math.round(n)}function fx(n){ie=n}var dx=Math.PI/180,px=180/Math.PI;function mx(n){return n*dx}function gx(n){return n*px}function _x(n,t){var e=arguments.length>2&&arguments[2]!==void 0?arguments[2]:xt;return Math.abs(n-t)<=e*Math.max(1,Math.abs(n),Math.abs(t))}var R={};na(R,{add:()=>nv,adjoint:()=>Ex,clone:()=>vx,copy:()=>yx,create:()=>xx,decompose:()=>Vx,determinant:()=>Ax,equals:()=>av,exactEquals:()=>sv,frob:()=>ev,fromQuat:()=>Xx,fromQuat2:()=>zx,fromRotation:()=>Ux,fromRotationTranslation:()=>yh,fromRotationTranslationScale:()=>Hx,fromRotationTranslationScaleOrigin:()=>Wx,fromScaling:()=>Dx,fromTranslation:()=>Lx,fromValues:()=>Sx,fromXRotation:()=>Fx,fromYRotation:()=>Ox,fromZRotation:()=>Bx,frustum:()=>qx,getRotation:()=>Gx,getScaling:()=>Sh,getTranslation:()=>kx,identity:()=>xh,invert:()=>wx,lookAt:()=>Qx,mul:()=>ov,multiply:()=>vh,multiplyScalar:()=>iv,multiplyScalarAndAdd:()=>rv,ortho:()=>$x,orthoNO:()=>bh,orthoZO:()=>Kx,perspective:()=>Yx,perspectiveFromFieldOfView:()=>Jx,perspectiveNO:()=>Mh,perspectiveZO:()=>Zx,rotate:()=>Cx,rotateX:()=>Ix,rotateY:()=>Px,rotateZ:()=>Nx,scale:()=>Rx,set:()=>Mx,str:()=>tv,sub:()=>lv,subtract:()=>wh,targetTo:()=>jx,translate:()=>Tx,transpose:()=>bx});function xx(){var n=new ie(16);return ie!=Float32Array&&(n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[11]=0,n[12]=0,n[13]=0,n[14]=0),n[0]=1,n[5]=1,n[10]=1,n[15]=1,n}function vx(n){var t=new ie(16);return t[0]=n[0],t[1]=n[1],t[2]=n[2],t[3]=n[3],t[4]=n[4],t[5]=n[5],t[6]=n[6],t[7]=n[7],t[8]=n[8],t[9]=n[9],t[10]=n[10],t[11]=n[11],t[12]=n[12],t[13]=n[13],t[14]=n[14],t[15]=n[15],t}function yx(n,t){return n[0]=t[0],n[1]=t[1],n[2]=t[2],n[3]=t[3],n[4]=t[4],n[5]=t[5],n[6]=t[6],n[7]=t[7],n[8]=t[8],n[9]=t[9],n[10]=t[10],n[11]=t[11],n[12]=t[12],n[13]=t[13],n[14]=t[14],n[15]=t[15],n}function Sx(n,t,e,i,r,s,a,o,h,l,c,u,d,f,p,m){var g=new ie(16);return g[0]=n,g[1]=t,g[2]=e,g[3]=i,g[4]=r,g[5]=s,g[6]=a,g[7]=o,g[8]=h,g[9]=l,g[10]=c,g[11]=u,g[12]=d,g[13]=f,g[14]=p,g[15]=m,g}function Mx(n,t,e,i,r,s,a,o,h,l,c,u,d,f,p,m,g){return n[0]=t,n[1]=e,n[2]=i,n[3]=r,n[4]=s,n[5]=a,n[6]=o,n[7]=h,n[8]=l,n[9]=c,n[10]=u,n[11]=d,n[12]=f,n[13]=p,n[14]=m,n[15]=g,n}function xh(n){return n[0]=1,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=1,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[10]=1,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n}function bx(n,t){if(n===t){var e=t[1],i=t[2],r=t[3],s=t[6],a=t[7],o=t[11];n[1]=t[4],n[2]=t[8],n[3]=t[12],n[4]=e,n[6]=t[9],n[7]=t[13],n[8]=i,n[9]=s,n[11]=t[14],n[12]=r,n[13]=a,n[14]=o}else n[0]=t[0],n[1]=t[4],n[2]=t[8],n[3]=t[12],n[4]=t[1],n[5]=t[5],n[6]=t[9],n[7]=t[13],n[8]=t[2],n[9]=t[6],n[10]=t[10],n[11]=t[14],n[12]=t[3],n[13]=t[7],n[14]=t[11],n[15]=t[15];return n}function wx(n,t){var e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8],u=t[9],d=t[10],f=t[11],p=t[12],m=t[13],g=t[14],_=t[15],y=e*o-i*a,v=e*h-r*a,x=e*l-s*a,w=i*h-r*o,b=i*l-s*o,A=r*l-s*h,I=c*m-u*p,C=c*g-d*p,P=c*_-f*p,L=u*g-d*m,G=u*_-f*m,q=d*_-f*g,V=y*q-v*G+x*L+w*P-b*C+A*I;return V?(V=1/V,n[0]=(o*q-h*G+l*L)*V,n[1]=(r*G-i*q-s*L)*V,n[2]=(m*A-g*b+_*w)*V,n[3]=(d*b-u*A-f*w)*V,n[4]=(h*P-a*q-l*C)*V,n[5]=(e*q-r*P+s*C)*V,n[6]=(g*x-p*A-_*v)*V,n[7]=(c*A-d*x+f*v)*V,n[8]=(a*G-o*P+l*I)*V,n[9]=(i*P-e*G-s*I)*V,n[10]=(p*b-m*x+_*y)*V,n[11]=(u*x-c*b-f*y)*V,n[12]=(o*C-a*L-h*I)*V,n[13]=(e*L-i*C+r*I)*V,n[14]=(m*v-p*w-g*y)*V,n[15]=(c*w-u*v+d*y)*V,n):null}function Ex(n,t){var e=t[0],i=t[1],r=t[2],s=t[3],a=t[4],o=t[5],h=t[6],l=t[7],c=t[8],u=t[9],d=t[10],f=t[11],p=t[12],m=t[13],g=t[14],_=t[15],y=e*o-i*a,v=e*h-r*a,x=e*l-s*a,w=i*h-r*o,b=i*l-s*o,A=r*l-s*h,I=c*m-u*p,C=c*g-d*p,P=c*_-f*p,L=u*g-d*m,G=u*_-f*m,q=d*_-f*g;return n[0]=o*q-h*G+l*L,n[1]=r*G-i*q-s*L,n[2]=m*A-g*b+_*w,n[3]=d*b-u*A-f*w,n[4]=h*P-a*q-l*C,n[5]=e*q-r*P+s*C,n[6]=g*x-p*A-_*v,n[7]=c*A-d*x+f*v,n[8]=a*G-o*P+l*I,n[9]=i*P-e*G-s*I,n[10]=p*b-m*x+_*y,n[11]=u*x-c*b-f*y,n[12]=o*C-a*L-h*I,n[13]=e*L-i*C+r*I,n[14]=m*v-p*w-g*y,n[15]=c*w-u*v+d*y,n}function Ax(n){var t=n[0],e=n[1],i=n[2],r=n[3],s=n[4],a=n[5],o=n[6],h=n[7],l=n[8],c=n[9],u=n[10],d=n[11],f=n[12],p=n[13],m=n[14],g=n[15],_=t*a-e*s,y=t*o-i*s,v=e*o-i*a,x=l*p-c*f,w=l*m-u*f,b=c*m-u*p,A=t*b-e*w+i*x,I=s*b-a*w+o*x,C=l*v-c*y+u*_,P=f*v-p*y+m*_;return h*A-r*I+g*C-d*P}function vh(n,t,e){var i=t[0],r=t[1],s=t[2],a=t[3],o=t[4],h=t[5],l=t[6],c=t[7],u=t[8],d=t[9],f=t[10],p=t[11],m=t[12],g=t[13],_=t[14],y=t[15],v=e[0],x=e[1],w=e[2],b=e[3];return n[0]=v*i+x*o+w*u+b*m,n[1]=v*r+x*h+w*d+b*g,n[2]=v*s+x*l+w*f+b*_,n[3]=v*a+x*c+w*p+b*y,v=e[4],x=e[5],w=e[6],b=e[7],n[4]=v*i+x*o+w*u+b*m,n[5]=v*r+x*h+w*d+b*g,n[6]=v*s+x*l+w*f+b*_,n[7]=v*a+x*c+w*p+b*y,v=e[8],x=e[9],w=e[10],b=e[11],n[8]=v*i+x*o+w*u+b*m,n[9]=v*r+x*h+w*d+b*g,n[10]=v*s+x*l+w*f+b*_,n[11]=v*a+x*c+w*p+b*y,v=e[12],x=e[13],w=e[14],b=e[15],n[12]=v*i+x*o+w*u+b*m,n[13]=v*r+x*h+w*d+b*g,n[14]=v*s+x*l+w*f+b*_,n[15]=v*a+x*c+w*p+b*y,n}function Tx(n,t,e){var i=e[0],r=e[1],s=e[2],a,o,h,l,c,u,d,f,p,m,g,_;return t===n?(n[12]=t[0]*i+t[4]*r+t[8]*s+t[12],n[13]=t[1]*i+t[5]*r+t[9]*s+t[13],n[14]=t[2]*i+t[6]*r+t[10]*s+t[14],n[15]=t[3]*i+t[7]*r+t[11]*s+t[15]):(a=t[0],o=t[1],h=t[2],l=t[3],c=t[4],u=t[5],d=t[6],f=t[7],p=t[8],m=t[9],g=t[10],_=t[11],n[0]=a,n[1]=o,n[2]=h,n[3]=l,n[4]=c,n[5]=u,n[6]=d,n[7]=f,n[8]=p,n[9]=m,n[10]=g,n[11]=_,n[12]=a*i+c*r+p*s+t[12],n[13]=o*i+u*r+m*s+t[13],n[14]=h*i+d*r+g*s+t[14],n[15]=l*i+f*r+_*s+t[15]),n}function Rx(n,t,e){var i=e[0],r=e[1],s=e[2];return n[0]=t[0]*i,n[1]=t[1]*i,n[2]=t[2]*i,n[3]=t[3]*i,n[4]=t[4]*r,n[5]=t[5]*r,n[6]=t[6]*r,n[7]=t[7]*r,n[8]=t[8]*s,n[9]=t[9]*s,n[10]=t[10]*s,n[11]=t[11]*s,n[12]=t[12],n[13]=t[13],n[14]=t[14],n[15]=t[15],n}function Cx(n,t,e,i){var r=i[0],s=i[1],a=i[2],o=Math.sqrt(r*r+s*s+a*a),h,l,c,u,d,f,p,m,g,_,y,v,x,w,b,A,I,C,P,L,G,q,V,B;return o<xt?null:(o=1/o,r*=o,s*=o,a*=o,h=Math.sin(e),l=Math.cos(e),c=1-l,u=t[0],d=t[1],f=t[2],p=t[3],m=t[4],g=t[5],_=t[6],y=t[7],v=t[8],x=t[9],w=t[10],b=t[11],A=r*r*c+l,I=s*r*c+a*h,C=a*r*c-s*h,P=r*s*c-a*h,L=s*s*c+l,G=a*s*c+r*h,q=r*a*c+s*h,V=s*a*c-r*h,B=a*a*c+l,n[0]=u*A+m*I+v*C,n[1]=d*A+g*I+x*C,n[2]=f*A+_*I+w*C,n[3]=p*A+y*I+b*C,n[4]=u*P+m*L+v*G,n[5]=d*P+g*L+x*G,n[6]=f*P+_*L+w*G,n[7]=p*P+y*L+b*G,n[8]=u*q+m*V+v*B,n[9]=d*q+g*V+x*B,n[10]=f*q+_*V+w*B,n[11]=p*q+y*V+b*B,t!==n&&(n[12]=t[12],n[13]=t[13],n[14]=t[14],n[15]=t[15]),n)}function Ix(n,t,e){var i=Math.sin(e),r=Math.cos(e),s=t[4],a=t[5],o=t[6],h=t[7],l=t[8],c=t[9],u=t[10],d=t[11];return t!==n&&(n[0]=t[0],n[1]=t[1],n[2]=t[2],n[3]=t[3],n[12]=t[12],n[13]=t[13],n[14]=t[14],n[15]=t[15]),n[4]=s*r+l*i,n[5]=a*r+c*i,n[6]=o*r+u*i,n[7]=h*r+d*i,n[8]=l*r-s*i,n[9]=c*r-a*i,n[10]=u*r-o*i,n[11]=d*r-h*i,n}function Px(n,t,e){var i=Math.sin(e),r=Math.cos(e),s=t[0],a=t[1],o=t[2],h=t[3],l=t[8],c=t[9],u=t[10],d=t[11];return t!==n&&(n[4]=t[4],n[5]=t[5],n[6]=t[6],n[7]=t[7],n[12]=t[12],n[13]=t[13],n[14]=t[14],n[15]=t[15]),n[0]=s*r-l*i,n[1]=a*r-c*i,n[2]=o*r-u*i,n[3]=h*r-d*i,n[8]=s*i+l*r,n[9]=a*i+c*r,n[10]=o*i+u*r,n[11]=h*i+d*r,n}function Nx(n,t,e){var i=Math.sin(e),r=Math.cos(e),s=t[0],a=t[1],o=t[2],h=t[3],l=t[4],c=t[5],u=t[6],d=t[7];return t!==n&&(n[8]=t[8],n[9]=t[9],n[10]=t[10],n[11]=t[11],n[12]=t[12],n[13]=t[13],n[14]=t[14],n[15]=t[15]),n[0]=s*r+l*i,n[1]=a*r+c*i,n[2]=o*r+u*i,n[3]=h*r+d*i,n[4]=l*r-s*i,n[5]=c*r-a*i,n[6]=u*r-o*i,n[7]=d*r-h*i,n}function Lx(n,t){return n[0]=1,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=1,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[10]=1,n[11]=0,n[12]=t[0],n[13]=t[1],n[14]=t[2],n[15]=1,n}function Dx(n,t){return n[0]=t[0],n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=t[1],n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[10]=t[2],n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n}function Ux(n,t,e){var i=e[0],r=e[1],s=e[2],a=Math.sqrt(i*i+r*r+s*s),o,h,l;return a<xt?null:(a=1/a,i*=a,r*=a,s*=a,o=Math.sin(t),h=Math.cos(t),l=1-h,n[0]=i*i*l+h,n[1]=r*i*l+s*o,n[2]=s*i*l-r*o,n[3]=0,n[4]=i*r*l-s*o,n[5]=r*r*l+h,n[6]=s*r*l+i*o,n[7]=0,n[8]=i*s*l+r*o,n[9]=r*s*l-i*o,n[10]=s*s*l+h,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n)}function Fx(n,t){var e=Math.sin(t),i=Math.cos(t);return n[0]=1,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=i,n[6]=e,n[7]=0,n[8]=0,n[9]=-e,n[10]=i,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n}function Ox(n,t){var e=Math.sin(t),i=Math.cos(t);return n[0]=i,n[1]=0,n[2]=-e,n[3]=0,n[4]=0,n[5]=1,n[6]=0,n[7]=0,n[8]=e,n[9]=0,n[10]=i,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n}function Bx(n,t){var e=Math.sin(t),i=Math.cos(t);return n[0]=i,n[1]=e,n[2]=0,n[3]=0,n[4]=-e,n[5]=i,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[10]=1,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n}function yh(n,t,e){var i=t[0],r=t[1],s=t[2],a=t[3],o=i+i,h=r+r,l=s+s,c=i*o,u=i*h,d=i*l,f=r*h,p=r*l,m=s*l,g=a*o,_=a*h,y=a*l;return n[0]=1-(f+m),n[1]=u+y,n[2]=d-_,n[3]=0,n[4]=u-y,n[5]=1-(c+m),n[6]=p+g,n[7]=0,n[8]=d+_,n[9]=p-g,n[10]=1-(c+f),n[11]=0,n[12]=e[0],n[13]=e[1],n[14]=e[2],n[15]=1,n}function zx(n,t){var e=new ie(3),i=-t[0],r=-t[1],s=-t[2],a=t[3],o=t[4],h=t[5],l=t[6],c=t[7],u=i*i+r*r+s*s+a*a;return u>0?(e[0]=(o*a+c*i+h*s-l*r)*2/u,e[1]=(h*a+c*r+l*i-o*s)*2/u,e[2]=(l*a+c*s+o*r-h*i)*2/u):(e[0]=(o*a+c*i+h*s-l*r)*2,e[1]=(h*a+c*r+l*i-o*s)*2,e[2]=(l*a+c*s+o*r-h*i)*2),yh(n,t,e),n}function kx(n,t){return n[0]=t[12],n[1]=t[13],n[2]=t[14],n}function Sh(n,t){var e=t[0],i=t[1],r=t[2],s=t[4],a=t[5],o=t[6],h=t[8],l=t[9],c=t[10];return n[0]=Math.sqrt(e*e+i*i+r*r),n[1]=Math.sqrt(s*s+a*a+o*o),n[2]=Math.sqrt(h*h+l*l+c*c),n}function Gx(n,t){var e=new ie(3);Sh(e,t);var i=1/e[0],r=1/e[1],s=1/e[2],a=t[0]*i,o=t[1]*r,h=t[2]*s,l=t[4]*i,c=t[5]*r,u=t[6]*s,d=t[8]*i,f=t[9]*r,p=t[10]*s,m=a+c+p,g=0;return m>0?(g=Math.sqrt(m+1)*2,n[3]=.25*g,n[0]=(u-f)/g,n[1]=(d-h)/g,n[2]=(o-l)/g):a>c&&a>p?(g=Math.sqrt(1+a-c-p)*2,n[3]=(u-f)/g,n[0]=.25*g,n[1]=(o+l)/g,n[2]=(d+h)/g):c>p?(g=Math.sqrt(1+c-a-p)*2,n[3]=(d-h)/g,n[0]=(o+l)/g,n[1]=.25*g,n[2]=(u+f)/g):(g=Math.sqrt(1+p-a-c)*2,n[3]=(o-l)/g,n[0]=(d+h)/g,n[1]=(u+f)/g,n[2]=.25*g),n}function Vx(n,t,e,i){t[0]=i[12],t[1]=i[13],t[2]=i[14];var r=i[0],s=i[1],a=i[2],o=i[4],h=i[5],l=i[6],c=i[8],u=i[9],d=i[10];e[0]=Math.sqrt(r*r+s*s+a*a),e[1]=Math.sqrt(o*o+h*h+l*l),e[2]=Math.sqrt(c*c+u*u+d*d);var f=1/e[0],p=1/e[1],m=1/e[2],g=r*f,_=s*p,y=a*m,v=o*f,x=h*p,w=l*m,b=c*f,A=u*p,I=d*m,C=g+x+I,P=0;return C>0?(P=Math.sqrt(C+1)*2,n[3]=.25*P,n[0]=(w-A)/P,n[1]=(b-y)/P,n[2]=(_-v)/P):g>x&&g>I?(P=Math.sqrt(1+g-x-I)*2,n[3]=(w-A)/P,n[0]=.25*P,n[1]=(_+v)/P,n[2]=(b+y)/P):x>I?(P=Math.sqrt(1+x-g-I)*2,n[3]=(b-y)/P,n[0]=(_+v)/P,n[1]=.25*P,n[2]=(w+A)/P):(P=Math.sqrt(1+I-g-x)*2,n[3]=(_-v)/P,n[0]=(b+y)/P,n[1]=(w+A)/P,n[2]=.25*P),n}function Hx(n,t,e,i){var r=t[0],s=t[1],a=t[2],o=t[3],h=r+r,l=s+s,c=a+a,u=r*h,d=r*l,f=r*c,p=s*l,m=s*c,g=a*c,_=o*h,y=o*l,v=o*c,x=i[0],w=i[1],b=i[2];return n[0]=(1-(p+g))*x,n[1]=(d+v)*x,n[2]=(f-y)*x,n[3]=0,n[4]=(d-v)*w,n[5]=(1-(u+g))*w,n[6]=(m+_)*w,n[7]=0,n[8]=(f+y)*b,n[9]=(m-_)*b,n[10]=(1-(u+p))*b,n[11]=0,n[12]=e[0],n[13]=e[1],n[14]=e[2],n[15]=1,n}function Wx(n,t,e,i,r){var s=t[0],a=t[1],o=t[2],h=t[3],l=s+s,c=a+a,u=o+o,d=s*l,f=s*c,p=s*u,m=a*c,g=a*u,_=o*u,y=h*l,v=h*c,x=h*u,w=i[0],b=i[1],A=i[2],I=r[0],C=r[1],P=r[2],L=(1-(m+_))*w,G=(f+x)*w,q=(p-v)*w,V=(f-x)*b,B=(1-(d+_))*b,pt=(g+y)*b,at=(p+v)*A,N=(g-y)*A,O=(1-(d+m))*A;return n[0]=L,n[1]=G,n[2]=q,n[3]=0,n[4]=V,n[5]=B,n[6]=pt,n[7]=0,n[8]=at,n[9]=N,n[10]=O,n[11]=0,n[12]=e[0]+I-(L*I+V*C+at*P),n[13]=e[1]+C-(G*I+B*C+N*P),n[14]=e[2]+P-(q*I+pt*C+O*P),n[15]=1,n}function Xx(n,t){var e=t[0],i=t[1],r=t[2],s=t[3],a=e+e,o=i+i,h=r+r,l=e*a,c=i*a,u=i*o,d=r*a,f=r*o,p=r*h,m=s*a,g=s*o,_=s*h;return n[0]=1-u-p,n[1]=c+_,n[2]=d-g,n[3]=0,n[4]=c-_,n[5]=1-l-p,n[6]=f+m,n[7]=0,n[8]=d+g,n[9]=f-m,n[10]=1-l-u,n[11]=0,n[12]=0,n[13]=0,n[14]=0,n[15]=1,n}function qx(n,t,e,i,r,s,a){var o=1/(e-t),h=1/(r-i),l=1/(s-a);return n[0]=s*2*o,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=s*2*h,n[6]=0,n[7]=0,n[8]=(e+t)*o,n[9]=(r+i)*h,n[10]=(a+s)*l,n[11]=-1,n[12]=0,n[13]=0,n[14]=a*s*2*l,n[15]=0,n}function Mh(n,t,e,i,r){var s=1/Math.tan(t/2);if(n[0]=s/e,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=s,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[11]=-1,n[12]=0,n[13]=0,n[15]=0,r!=null&&r!==1/0){var a=1/(i-r);n[10]=(r+i)*a,n[14]=2*r*i*a}else n[10]=-1,n[14]=-2*i;return n}var Yx=Mh;function Zx(n,t,e,i,r){var s=1/Math.tan(t/2);if(n[0]=s/e,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=s,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[11]=-1,n[12]=0,n[13]=0,n[15]=0,r!=null&&r!==1/0){var a=1/(i-r);n[10]=r*a,n[14]=r*i*a}else n[10]=-1,n[14]=-i;return n}function Jx(n,t,e,i){var r=Math.tan(t.upDegrees*Math.PI/180),s=Math.tan(t.downDegrees*Math.PI/180),a=Math.tan(t.leftDegrees*Math.PI/180),o=Math.tan(t.rightDegrees*Math.PI/180),h=2/(a+o),l=2/(r+s);return n[0]=h,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=l,n[6]=0,n[7]=0,n[8]=-((a-o)*h*.5),n[9]=(r-s)*l*.5,n[10]=i/(e-i),n[11]=-1,n[12]=0,n[13]=0,n[14]=i*e/(e-i),n[15]=0,n}function bh(n,t,e,i,r,s,a){var o=1/(t-e),h=1/(i-r),l=1/(s-a);return n[0]=-2*o,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=-2*h,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[10]=2*l,n[11]=0,n[12]=(t+e)*o,n[13]=(r+i)*h,n[14]=(a+s)*l,n[15]=1,n}var $x=bh;function Kx(n,t,e,i,r,s,a){var o=1/(t-e),h=1/(i-r),l=1/(s-a);return n[0]=-2*o,n[1]=0,n[2]=0,n[3]=0,n[4]=0,n[5]=-2*h,n[6]=0,n[7]=0,n[8]=0,n[9]=0,n[10]=l,n[11]=0,n[12]=(t+e)*o,n[13]=(r+i)*h,n[14]=s*l,n[15]=1,n}function Qx(n,t,e,i){var r,s,a,o,h,l,c,u,d,f,p=t[0],m=t[1],g=t[2],_=i[0],y=i[1],v=i[2],x=e[0],w=e[1],b=e[2];return Math.abs(p-x)<xt&&Math.abs(m-w)<xt&&Math.abs(g-b)<xt?xh(n):(c=p-x,u=m-w,d=g-b,f=1/Math.sqrt(c*c+u*u+d*d),c*=f,u*=f,d*=f,r=y*d-v*u,s=v*c-_*d,a=_*u-y*c,f=Math.sqrt(r*r+s*s+a*a),f?(f=1/f,r*=f,s*=f,a*=f):(r=0,s=0,a=0),o=u*a-d*s,h=d*r-c*a,l=c*s-u*r,f=Math.sqrt(o*o+h*h+l*l),f?(f=1/f,o*=f,h*=f,l*=f):(o=0,h=0,l=0),n[0]=r,n[1]=o,n[2]=c,n[3]=0,n[4]=s,n[5]=h,n[6]=u,n[7]=0,n[8]=a,n[9]=l,n[10]=d,n[11]=0,n[12]=-(r*p+s*m+a*g),n[13]=-(o*p+h*m+l*g),n[14]=-(c*p+u*m+d*g),n[15]=1,n)}function jx(n,t,e,i){var r=t[0],s=t[1],a=t[2],o=i[0],h=i[1],l=i[2],c=r-e[0],u=s-e[1],d=a-e[2],f=c*c+u*u+d*d;f>0&&(f=1/Math.sqrt(f),c*=f,u*=f,d*=f);var p=h*d-l*u,m=l*c-o*d,g=o*u-h*c;return f=p*p+m*m+g*g,f>0&&(f=1/Math.sqrt(f),p*=f,m*=f,g*=f),n[0]=p,n[1]=m,n[2]=g,n[3]=0,n[4]=u*g-d*m,n[5]=d*p-c*g,n[6]=c*m-u*p,n[7]=0,n[8]=c,n[9]=u,n[10]=d,n[11]=0,n[12]=r,n[13]=s,n[14]=a,n[15]=1,n}function tv(n){return"mat4("+n[0]+", "+n[1]+", "+n[2]+", "+n[3]+", "+n[4]+", "+n[5]+", "+n[6]+", "+n[7]+", "+n[8]+", "+n[9]+", "+n[10]+", "+n[11]+", "+n[12]+", "+n[13]+", "+n[14]+", "+n[15]+")"}function ev(n){return Math.sqrt(n[0]*n[0]+n[1]*n[1]+n[2]*n[2]+n[3]*n[3]+n[4]*n[4]+n[5]*n[5]+n[6]*n[6]+n[7]*n[7]+n[8]*n[8]+n[9]*n[9]+n[10]*n[10]+n[11]*n[11]+n[12]*n[12]+n[13]*n[13]+n[14]*n[14]+n[15]*n[15])}function nv(n,t,e){return n[0]=t[0]+e[0],n[1]=t[1]+e[1],n[2]=t[2]+e[2],n[3]=t[3]+e[3],n[4]=t[4]+e[4],n[5]=t[5]+e[5],n[6]=t[6]+e[6],n[7]=t[7]+e[7],n[8]=t[8]+e[8],n[9]=t[9]+e[9],n[10]=t[10]+e[10],n[11]=t[11]+e[11],n[12]=t[12]+e[12],n[13]=t[13]+e[13],n[14]=t[14]+e[14],n[15]=t[15]+e[15],n}function wh(n,t,e){return n[0]=t[0]-e[0],n[1]=t[1]-e[1],n[2]=t[2]-e[2],n[3]=t[3]-e[3],n[4]=t[4]-e[4],n[5]=t[5]-e[5],n[6]=t[6]-e[6],n[7]=t[7]-e[7],n[8]=t[8]-e[8],n[9]=t[9]-e[9],n[10]=t[10]-e[10],n[11]=t[11]-e[11],n[12]=t[12]-e[12],n[13]=t[13]-e[13],n[14]=t[14]-e[14],n[15]=t[15]-e[15],n}function iv(n,t,e){return n[0]=t[0]*e,n[1]=t[1]*e,n[2]=t[2]*e,n[3]=t[3]*e,n[4]=t[4]*e,n[5]=t[5]*e,n[6]=t[6]*e,n[7]=t[7]*e,n[8]=t[8]*e,n[9]=t[9]*e,n[10]=t[10]*e,n[11]=t[11]*e,n[12]=t[12]*e,n[13]=t[13]*e,n[14]=t[14]*e,n[15]=t[15]*e,n}function rv(n,t,e,i){return n[0]=t[0]+e[0]*i,n[1]=t[1]+e[1]*i,n[2]=t[2]+e[2]*i,n[3]=t[3]+e[3]*i,n[4]=t[4]+e[4]*i,n[5]=t[5]+e[5]*i,n[6]=t[6]+e[6]*i,n[7]=t[7]+e[7]*i,n[8]=t[8]+e[8]*i,n[9]=t[9]+e[9]*i,n[10]=t[10]+e[10]*i,n[11]=t[11]+e[11]*i,n[12]=t[12]+e[12]*i,n[13]=t[13]+e[13]*i,n[14]=t[14]+e[14]*i,n[15]=t[15]+e[15]*i,n}function sv(n,t){return n[0]===t[0]&&n[1]===t[1]&&n[2]===t[2]&&n[3]===t[3]&&n[4]===t[4]&&n[5]===t[5]&&n[6]===t[6]&&n[7]===t[7]&&n[8]===t[8]&&n[9]===t[9]&&n[10]===t[10]&&n[11]===t[11]&&n[12]===t[12]&&n[13]===t[13]&&n[14]===t[14]&&n[15]===t[15]}function av(n,t){var e=n[0],i=n[1],r=n[2],s=n[3],a=n[4],o=n[5],h=n[6],l=n[7],c=n[8],u=n[9],d=n[10],f=n[11],p=n[12],m=n[13],g=n[14],_=n[15],y=t[0],v=t[1],x=t[2],w=t[3],b=t[4],A=t[5],I=t[6],C=t[7],P=t[8],L=t[9],G=t[10],q=t[11],V=t[12],B=t[13],pt=t[14],at=t[15];return Math.abs(e-y)<=xt*Math.max(1,Math.abs(e),Math.abs(y))&&Math.abs(i-v)<=xt*Math.max(1,Math.abs(i),Math.abs(v))&&Math.abs(r-x)<=xt*Math.max(1,Math.abs(r),Math.abs(x))&&Math.abs(s-w)<=xt*Math.max(1,Math.abs(s),Math.abs(w))&&Math.abs(a-b)<=xt*Math.max(1,Math.abs(a),Math.abs(b))&&Math.abs(o-A)<=xt*Math.max(1,Math.abs(o),Math.abs(A))&&Math.abs(h-I)<=xt*Math.max(1,Math.abs(h),Math.abs(I))&&Math.abs(l-C)<=xt*Math.max(1,Math.abs(l),Math.abs(C))&&Math.abs(c-P)<=xt*Math.max(1,Math.abs(c),Math.abs(P))&&Math.abs(u-L)<=xt*Math.max(1,Math.abs(u),Math.abs(L))&&Math.abs(d-G)<=xt*Math.max(1,Math.abs(d),Math.abs(G))&&Math.abs(f-q)<=xt*Math.max(1,Math.abs(f),Math.abs(q))&&Math.abs(p-V)<=xt*Math.max(1,Math.abs(p),Math.abs(V))&&Math.abs(m-B)<=xt*Math.max(1,Math.abs(m),Math.abs(B))&&Math.abs(g-pt)<=xt*Math.max(1,Math.abs(g),Math.abs(pt))&&Math.abs(_-at)<=xt*Math.max(1,Math.abs(_),Math.abs(at))}var ov=vh,lv=wh;var fn={};na(fn,{add:()=>dv,angle:()=>Fv,bezier:()=>Rv,ceil:()=>pv,clone:()=>cv,copy:()=>uv,create:()=>Eh,cross:()=>wv,dist:()=>Wv,distance:()=>Ih,div:()=>Hv,divide:()=>Ch,dot:()=>ko,equals:()=>kv,exactEquals:()=>zv,floor:()=>mv,forEach:()=>Zv,fromValues:()=>hv,hermite:()=>Tv,inverse:()=>Mv,len:()=>qv,length:()=>Ah,lerp:()=>Ev,max:()=>_v,min:()=>gv,mul:()=>Vv,multiply:()=>Rh,negate:()=>Sv,normalize:()=>bv,random:()=>Cv,rotateX:()=>Lv,rotateY:()=>Dv,rotateZ:()=>Uv,round:()=>xv,scale:()=>vv,scaleAndAdd:()=>yv,set:()=>fv,slerp:()=>Av,sqrDist:()=>Xv,sqrLen:()=>Yv,squaredDistance:()=>Ph,squaredLength:()=>Nh,str:()=>Bv,sub:()=>Gv,subtract:()=>Th,transformMat3:()=>Pv,transformMat4:()=>Iv,transformQuat:()=>Nv,zero:()=>Ov});function Eh(){var n=new ie(3);return ie!=Float32Array&&(n[0]=0,n[1]=0,n[2]=0),n}function cv(n){var t=new ie(3);return t[0]=n[0],t[1]=n[1],t[2]=n[2],t}function Ah(n){var t=n[0],e=n[1],i=n[2];return Math.sqrt(t*t+e*e+i*i)}function hv(n,t,e){var i=new ie(3);return i[0]=n,i[1]=t,i[2]=e,i}function uv(n,t){return n[0]=t[0],n[1]=t[1],n[2]=t[2],n}function fv(n,t,e,i){return n[0]=t,n[1]=e,n[2]=i,n}function dv(n,t,e){return n[0]=t[0]+e[0],n[1]=t[1]+e[1],n[2]=t[2]+e[2],n}function Th(n,t,e){return n[0]=t[0]-e[0],n[1]=t[1]-e[1],n[2]=t[2]-e[2],n}function Rh(n,t,e){return n[0]=t[0]*e[0],n[1]=t[1]*e[1],n[2]=t[2]*e[2],n}function Ch(n,t,e){return n[0]=t[0]/e[0],n[1]=t[1]/e[1],n[2]=t[2]/e[2],n}function pv(n,t){return n[0]=Math.ceil(t[0]),n[1]=Math.ceil(t[1]),n[2]=Math.ceil(t[2]),n}function mv(n,t){return n[0]=Math.floor(t[0]),n[1]=Math.floor(t[1]),n[2]=Math.floor(t[2]),n}function gv(n,t,e){return n[0]=Math.min(t[0],e[0]),n[1]=Math.min(t[1],e[1]),n[2]=Math.min(t[2],e[2]),n}function _v(n,t,e){return n[0]=Math.max(t[0],e[0]),n[1]=Math.max(t[1],e[1]),n[2]=Math.max(t[2],e[2]),n}function xv(n,t){return n[0]=ji(t[0]),n[1]=ji(t[1]),n[2]=ji(t[2]),n}function vv(n,t,e){return n[0]=t[0]*e,n[1]=t[1]*e,n[2]=t[2]*e,n}function yv(n,t,e,i){return n[0]=t[0]+e[0]*i,n[1]=t[1]+e[1]*i,n[2]=t[2]+e[2]*i,n}function Ih(n,t){var e=t[0]-n[0],i=t[1]-n[1],r=t[2]-n[2];return Math.sqrt(e*e+i*i+r*r)}function Ph(n,t){var e=t[0]-n[0],i=t[1]-n[1],r=t[2]-n[2];return e*e+i*i+r*r}function Nh(n){var t=n[0],e=n[1],i=n[2];return t*t+e*e+i*i}function Sv(n,t){return n[0]=-t[0],n[1]=-t[1],n[2]=-t[2],n}function Mv(n,t){return n[0]=1/t[0],n[1]=1/t[1],n[2]=1/t[2],n}function bv(n,t){var e=t[0],i=t[1],r=t[2],s=e*e+i*i+r*r;return s>0&&(s=1/Math.sqrt(s)),n[0]=t[0]*s,n[1]=t[1]*s,n[2]=t[2]*s,n}function ko(n,t){return n[0]*t[0]+n[1]*t[1]+n[2]*t[2]}function wv(n,t,e){var i=t[0],r=t[1],s=t[2],a=e[0],o=e[1],h=e[2];return n[0]=r*h-s*o,n[1]=s*a-i*h,n[2]=i*o-r*a,n}function Ev(n,t,e,i){var r=t[0],s=t[1],a=t[2];return n[0]=r+i*(e[0]-r),n[1]=s+i*(e[1]-s),n[2]=a+i*(e[2]-a),n}function Av(n,t,e,i){var r=Math.acos(Math.min(Math.max(ko(t,e),-1),1)),s=Math.sin(r),a=Math.sin((1-i)*r)/s,o=Math.sin(i*r)/s;return n[0]=a*t[0]+o*e[0],n[1]=a*t[1]+o*e[1],n[2]=a*t[2]+o*e[2],n}function Tv(n,t,e,i,r,s){var a=s*s,o=a*(2*s-3)+1,h=a*(s-2)+s,l=a*(s-1),c=a*(3-2*s);return n[0]=t[0]*o+e[0]*h+i[0]*l+r[0]*c,n[1]=t[1]*o+e[1]*h+i[1]*l+r[1]*c,n[2]=t[2]*o+e[2]*h+i[2]*l+r[2]*c,n}function Rv(n,t,e,i,r,s){var a=1-s,o=a*a,h=s*s,l=o*a,c=3*s*o,u=3*h*a,d=h*s;return n[0]=t[0]*l+e[0]*c+i[0]*u+r[0]*d,n[1]=t[1]*l+e[1]*c+i[1]*u+r[1]*d,n[2]=t[2]*l+e[2]*c+i[2]*u+r[2]*d,n}function Cv(n,t){t=t===void 0?1:t;var e=ws()*2*Math.PI,i=ws()*2-1,r=Math.sqrt(1-i*i)*t;return n[0]=Math.cos(e)*r,n[1]=Math.sin(e)*r,n[2]=i*t,n}function Iv(n,t,e){var i=t[0],r=t[1],s=t[2],a=e[3]*i+e[7]*r+e[11]*s+e[15];return a=a||1,n[0]=(e[0]*i+e[4]*r+e[8]*s+e[12])/a,n[1]=(e[1]*i+e[5]*r+e[9]*s+e[13])/a,n[2]=(e[2]*i+e[6]*r+e[10]*s+e[14])/a,n}function Pv(n,t,e){var i=t[0],r=t[1],s=t[2];return n[0]=i*e[0]+r*e[3]+s*e[6],n[1]=i*e[1]+r*e[4]+s*e[7],n[2]=i*e[2]+r*e[5]+s*e[8],n}function Nv(n,t,e){var i=e[0],r=e[1],s=e[2],a=e[3],o=t[0],h=t[1],l=t[2],c=r*l-s*h,u=s*o-i*l,d=i*h-r*o;return c=c+c,u=u+u,d=d+d,n[0]=o+a*c+r*d-s*u,n[1]=h+a*u+s*c-i*d,n[2]=l+a*d+i*u-r*c,n}function Lv(n,t,e,i){var r=[],s=[];return r[0]=t[0]-e[0],r[1]=t[1]-e[1],r[2]=t[2]-e[2],s[0]=r[0],s[1]=r[1]*Math.cos(i)-r[2]*Math.sin(i),s[2]=r[1]*Math.sin(i)+r[2]*Math.cos(i),n[0]=s[0]+e[0],n[1]=s[1]+e[1],n[2]=s[2]+e[2],n}function Dv(n,t,e,i){var r=[],s=[];return r[0]=t[0]-e[0],r[1]=t[1]-e[1],r[2]=t[2]-e[2],s[0]=r[2]*Math.sin(i)+r[0]*Math.cos(i),s[1]=r[1],s[2]=r[2]*Math.cos(i)-r[0]*Math.sin(i),n[0]=s[0]+e[0],n[1]=s[1]+e[1],n[2]=s[2]+e[2],n}function Uv(n,t,e,i){var r=[],s=[];return r[0]=t[0]-e[0],r[1]=t[1]-e[1],r[2]=t[2]-e[2],s[0]=r[0]*Math.cos(i)-r[1]*Math.sin(i),s[1]=r[0]*Math.sin(i)+r[1]*Math.cos(i),s[2]=r[2],n[0]=s[0]+e[0],n[1]=s[1]+e[1],n[2]=s[2]+e[2],n}function Fv(n,t){var e=n[0],i=n[1],r=n[2],s=t[0],a=t[1],o=t[2],h=Math.sqrt((e*e+i*i+r*r)*(s*s+a*a+o*o)),l=h&&ko(n,t)/h;return Math.acos(Math.min(Math.max(l,-1),1))}function Ov(n){return n[0]=0,n[1]=0,n[2]=0,n}function Bv(n){return"vec3("+n[0]+", "+n[1]+", "+n[2]+")"}function zv(n,t){return n[0]===t[0]&&n[1]===t[1]&&n[2]===t[2]}function kv(n,t){var e=n[0],i=n[1],r=n[2],s=t[0],a=t[1],o=t[2];return Math.abs(e-s)<=xt*Math.max(1,Math.abs(e),Math.abs(s))&&Math.abs(i-a)<=xt*Math.max(1,Math.abs(i),Math.abs(a))&&Math.abs(r-o)<=xt*Math.max(1,Math.abs(r),Math.abs(o))}var Gv=Th,Vv=Rh,Hv=Ch,Wv=Ih,Xv=Ph,qv=Ah,Yv=Nh,Zv=(function(){var n=Eh();return function(t,e,i,r,s,a){var o,h;for(e||(e=3),i||(i=0),r?h=Math.min(r*e+i,t.length):h=t.length,o=i;o<h;o+=e)n[0]=t[o],n[1]=t[o+1],n[2]=t[o+2],s(n,n,a),t[o]=n[0],t[o+1]=n[1],t[o+2]=n[2];return t}})();var Bt=class n{x;y;z;constructor(t,e,i){this.x=t,this.y=e,this.z=i}length(){return Math.sqrt(this.x*this.x+this.y*this.y+this.z*this.z)}lengthSquared(){return this.x*this.x+this.y*this.y+this.z*this.z}distance(t){return this.sub(t).length()}distanceSquared(t){return this.sub(t).lengthSquared()}abs(){return new n(Math.abs(this.x),Math.abs(this.y),Math.abs(this.z))}add(t){return new n(this.x+t.x,this.y+t.y,this.z+t.z)}sub(t){return new n(this.x-t.x,this.y-t.y,this.z-t.z)}mul(t){return new n(this.x*t.x,this.y*t.y,this.z*t.z)}div(t){return new n(this.x/t.x,this.y/t.y,this.z/t.z)}scale(t){return new n(this.x*t,this.y*t,this.z*t)}dot(t){return this.x*t.x+this.y*t.y+this.z*t.z}cross(t){let e=this.y*t.z-this.z*t.y,i=this.z*t.x-this.x*t.z,r=this.x*t.y-this.y*t.x;return new n(e,i,r)}normalize(){if(this.x==0&&this.y==0&&this.z==0)return this;let t=1/this.length();return new n(this.x*t,this.y*t,this.z*t)}components(){return[this.x,this.y,this.z]}toString(){return`[${this.x} ${this.y} ${this.z}]`}};var pi=class{layers;_range;constructor(t){this.layers=t;let e=X.ofExact(0);for(let i of t){let r=X.mul(i.noise.range(),X.ofExact(i.amplitude));e=X.add(e,r)}this._range=e}range(){return this._range}get2D(t,e){let i=0;for(let r of this.layers)i+=r.amplitude*r.noise.get2D(t*r.frequency,e*r.frequency);return i}get3D(t,e,i){let r=0;for(let s of this.layers)r+=s.amplitude*s.noise.get3D(t*s.frequency,e*s.frequency,i*s.frequency);return r}};var It=class n{static GRADIENT=[[1,1,0],[-1,1,0],[1,-1,0],[-1,-1,0],[1,0,1],[-1,0,1],[1,0,-1],[-1,0,-1],[0,1,1],[0,-1,1],[0,1,-1],[0,-1,-1],[1,1,0],[0,-1,1],[-1,1,0],[0,-1,-1]];perms;offsetX;offsetY;offsetZ;constructor(t,e=256){this.offsetX=t.nextDouble()*e,this.offsetY=t.nextDouble()*e,this.offsetZ=t.nextDouble()*e,this.perms=Array(256);for(let i=0;i<256;i+=1)this.perms[i]=i;for(let i=0;i<256;i+=1){let r=t.nextInt(256-i),s=this.perms[i];this.perms[i]=this.perms[i+r],this.perms[i+r]=s}}permute(t){return this.perms[t&255]&255}static wrap(t){return t-ph(t/33554432+.5)*33554432}static gradDot(t,e,i,r){let s=n.GRADIENT[t&15];return s[0]*e+s[1]*i+s[2]*r}};var dn=class n extends It{static RANGE=X.ofSymmetric(2);static STANDARD_DEVIATION=.2702247831245211;constructor(t){super(t)}range(){return n.RANGE}get2D(t,e){return this.get3D(It.wrap(t),0,It.wrap(e))}get3D(t,e,i){let r=It.wrap(t)+this.offsetX,s=It.wrap(e)+this.offsetY,a=It.wrap(i)+this.offsetZ,o=ve(r),h=ve(s),l=ve(a),c=r-o,u=s-h,d=a-l;return this.sampleAndLerp(o,h,l,c,u,d,u)}sampleAndLerp(t,e,i,r,s,a,o){let h=this.permute(t),l=this.permute(t+1),c=this.permute(h+e),u=this.permute(h+e+1),d=this.permute(l+e),f=this.permute(l+e+1),p=It.gradDot(this.permute(c+i),r,s,a),m=It.gradDot(this.permute(d+i),r-1,s,a),g=It.gradDot(this.permute(u+i),r,s-1,a),_=It.gradDot(this.permute(f+i),r-1,s-1,a),y=It.gradDot(this.permute(c+i+1),r,s,a-1),v=It.gradDot(this.permute(d+i+1),r-1,s,a-1),x=It.gradDot(this.permute(u+i+1),r,s-1,a-1),w=It.gradDot(this.permute(f+i+1),r-1,s-1,a-1),b=vs(r),A=vs(o),I=vs(a);return uh(b,A,I,p,m,g,_,y,v,x,w)}};var Jv=["disabled","enabled","legacy"],An=class n{baseAmplitude;baseOctave;octaveCount;normalize;amplitudeModifiers;static INPUT_FACTOR=1.0181268882175227;static TARGET_DEVIATION=.3333333333333333;octaves;normalizationFactor;range;constructor(t,e,i,r,s){this.baseAmplitude=t,this.baseOctave=e,this.octaveCount=i,this.normalize=r,this.amplitudeModifiers=s,this.octaves=n.buildOctaves(t,e,i,r!="disabled",s);let a=this.octaves.reduce((h,l)=>h+Math.abs(l.amplitude),0),o=n.computeNormalizationFactor(a,this.octaves);if(r=="legacy"&&o!=0){let h=n.computeParityNormalizationFactor(t,i,s);a*=h/o,o=h}this.normalizationFactor=o,this.range=X.ofSymmetric(a*n.TARGET_DEVIATION*6)}create(t){let e=t.forkPositional(),i=t.forkPositional(),r=[];for(let s of this.octaves){let a=`octave_${s.index}`,o=new dn(e.fromHashOf(a)),h=new dn(i.fromHashOf(a)),l=this.normalizationFactor*s.amplitude;r.push({noise:o,frequency:s.frequency,amplitude:l}),r.push({noise:h,frequency:s.frequency*n.INPUT_FACTOR,amplitude:l})}return new pi(r)}createForLegacyNetherBiome(t){let e=this.amplitudeModifiers;e.length===0&&(e=Array(this.octaveCount).fill(1));let i=n.createLegacyNoiseLayers(t,this.baseOctave,e),r=n.createLegacyNoiseLayers(t,this.baseOctave,e),s=this.normalizationFactor*this.baseAmplitude;return new pi([...i.map(a=>({...a,amplitude:a.amplitude*s})),...r.map(a=>({...a,frequency:a.frequency*n.INPUT_FACTOR,amplitudes:a.amplitude*s}))])}static createLegacyNoiseLayers(t,e,i){let r=i.length,s=-e,a=Array(r).fill(void 0),o=new dn(t);s>=0&&s<r&&i[s]!=0&&(a[s]=o);for(let u=s-1;u>=0;u-=1)u<r&&i[u]!=0?a[u]=new dn(t):t.consume(262);let h=Math.pow(2,-s),l=Math.pow(2,r-1)/(Math.pow(2,r)-1),c=[];for(let u=0;u<a.length;u+=1){let d=a[u];d!=null&&c.push({noise:d,frequency:h,amplitude:l}),h*=2,l/=2}return c}static computeParityNormalizationFactor(t,e,i){let r=1/0,s=-1/0;for(let o=0;o<e;o+=1)(i[o]??1)!=0&&(r=Math.min(r,o),s=Math.max(s,o));let a=.1*(1+1/(s-r+1));return t*.5*n.TARGET_DEVIATION/a}static computeNormalizationFactor(t,e){let i=0;for(let s of e)i+=Re(.2702247831245211*Math.abs(s.amplitude));let r=Math.sqrt(i);return r===0?0:t*n.TARGET_DEVIATION/(r*Math.sqrt(2))}static buildOctaves(t,e,i,r,s){let a=Math.pow(2,e),o=t;r&&(o*=Math.pow(.5,-(i-1))/(Math.pow(.5,-i)-1));let h=[];for(let l=0;l<i;l+=1){let c=s[l]??1;c!=0&&h.push({index:e+l,frequency:a,amplitude:o*c}),a*=2,o*=.5}return h}static fromJson(t){let e=M.readObject(t)??{},i=typeof e.normalize=="boolean"?e.normalize?"enabled":"disabled":e.normalize?M.readEnum(e.normalize,Jv):"enabled";return new n(M.readNumber(e.base_amplitude)??1,M.readInt(e.base_octave)??0,M.readInt(e.octave_count)??1,i,M.readArray(e.amplitude_modifiers,r=>M.readNumber(r)??0)??[])}};var Es=class n extends It{static RANGE=X.ofSymmetric(2);static STANDARD_DEVIATION=.42544;static F2=.5*(Math.sqrt(3)-1);static G2=(3-Math.sqrt(3))/6;constructor(t,e){super(t,e?0:void 0)}range(){return n.RANGE}get2D(t,e){let i=t+this.offsetX,r=e+this.offsetY,s=(i+r)*n.F2,a=ve(i+s),o=ve(r+s),h=(a+o)*n.G2,l=i-(a-h),c=r-(o-h),u,d;l>c?(u=1,d=0):(u=0,d=1);let f=l-u+n.G2,p=c-d+n.G2,m=l-1+2*n.G2,g=c-1+2*n.G2,_=a&255,y=o&255,v=this.permute(_+this.permute(y))%12,x=this.permute(_+u+this.permute(y+d))%12,w=this.permute(_+1+this.permute(y+1))%12,b=this.getCornerNoise3D(v,l,c,0,.5),A=this.getCornerNoise3D(x,f,p,0,.5),I=this.getCornerNoise3D(w,m,g,0,.5);return 70*(b+A+I)}get3D(t,e,i){let r=t+this.offsetX,s=e+this.offsetY,a=i+this.offsetZ,o=(r+s+a)*.3333333333333333,h=ve(r+o),l=ve(s+o),c=ve(a+o),u=(h+l+c)*.16666666666666666,d=r-(h-u),f=s-(l-u),p=a-(c-u),m,g,_,y,v,x;d>=f?f>=p?(m=1,g=0,_=0,y=1,v=1,x=0):d>=p?(m=1,g=0,_=0,y=1,v=0,x=1):(m=0,g=0,_=1,y=1,v=0,x=1):f<p?(m=0,g=0,_=1,y=0,v=1,x=1):d<p?(m=0,g=1,_=0,y=0,v=1,x=1):(m=0,g=1,_=0,y=1,v=1,x=0);let w=d-m+.16666666666666666,b=f-g+.16666666666666666,A=p-_+.16666666666666666,I=d-y+.3333333333333333,C=f-v+.3333333333333333,P=p-x+.3333333333333333,L=d-.5,G=f-.5,q=p-.5,V=h&255,B=l&255,pt=c&255,at=this.permute(V+this.permute(B+this.permute(pt)))%12,N=this.permute(V+m+this.permute(B+g+this.permute(pt+_)))%12,O=this.permute(V+y+this.permute(B+v+this.permute(pt+x)))%12,H=this.permute(V+1+this.permute(B+1+this.permute(pt+1)))%12,gt=this.getCornerNoise3D(at,d,f,p,.6),Q=this.getCornerNoise3D(N,w,b,A,.6),Rt=this.getCornerNoise3D(O,I,C,P,.6),j=this.getCornerNoise3D(H,L,G,q,.6);return 32*(gt+Q+Rt+j)}getCornerNoise3D(t,e,i,r,s){let a=s-e*e-i*i-r*r,o;return a<0?o=0:(a*=a,o=a*a*n.gradDot(t,e,i,r)),o}};var zt=class n{static MODULUS_BITS=48;static MODULUS_MASK=BigInt("281474976710655");static MULTIPLIER=BigInt("25214903917");static INCREMENT=BigInt("11");static FLOAT_MULTIPLIER=1/Math.pow(2,24);static DOUBLE_MULTIPLIER=1/Math.pow(2,30);seed=BigInt(0);constructor(t){this.setSeed(t)}static fromLargeFeatureSeed(t,e,i){let r=new n(t),s=r.nextLong(),a=r.nextLong(),o=BigInt(e)*s^BigInt(i)*a^t;return r.setSeed(o),r}static fromLargeFeatureWithSalt(t,e,i,r){let s=BigInt(e)*BigInt("341873128712")+BigInt(i)*BigInt("132897987541")+t+BigInt(r);return new n(s)}fork(){return new n(this.nextLong())}forkPositional(){return new Go(this.nextLong())}setSeed(t){this.seed=(t^n.MULTIPLIER)&n.MODULUS_MASK}advance(){this.seed=this.seed*n.MULTIPLIER+n.INCREMENT&n.MODULUS_MASK}consume(t){for(let e=0;e<t;e+=1)this.advance()}next(t){this.advance();let e=Number(this.seed>>BigInt(n.MODULUS_BITS-t));return e>2147483647?e-4294967296:e}nextInt(t){if(t===void 0)return this.next(32);if((t&t-1)==0)return Number(BigInt(t)*BigInt(this.next(31))>>BigInt(31));let e,i;for(;(e=this.next(31))-(i=e%t)+(t-1)<0;);return i}nextLong(){return(BigInt(this.next(32))<<BigInt(32))+BigInt(this.next(32))}nextFloat(){return this.next(24)*n.FLOAT_MULTIPLIER}nextDouble(){let t=this.next(30);return this.advance(),t*n.DOUBLE_MULTIPLIER}},Go=class{seed;constructor(t){this.seed=t}at(t,e,i){let r=Ss(t,e,i);return new zt(r^this.seed)}fromHashOf(t){let e=_h(t);return new zt(BigInt(e)^this.seed)}seedKey(){return[this.seed,BigInt(0)]}};var Gh=wf(kh(),1);var tr=class n{static SILVER_RATIO_64=BigInt("7640891576956012809");static GOLDEN_RATIO_64=BigInt("-7046029254386353131");static FLOAT_MULTIPLIER=1/Math.pow(2,24);static DOUBLE_MULTIPLIER=11102230246251565e-32;static BIGINT_1=BigInt(1);static BIGINT_17=BigInt(17);static BIGINT_21=BigInt(21);static BIGINT_27=BigInt(27);static BIGINT_28=BigInt(28);static BIGINT_30=BigInt(30);static BIGINT_31=BigInt(31);static BIGINT_32=BigInt(32);static BIGINT_49=BigInt(49);static BIGINT_64=BigInt(64);static STAFFORD_1=BigInt("-4658895280553007687");static STAFFORD_2=BigInt("-7723592293110705685");static MAX_ULONG=BigInt("0xFFFFFFFFFFFFFFFF");static POW2_60=BigInt("0x10000000000000000");static POW2_63=BigInt("0x8000000000000000");static MAX_UINT=BigInt(4294967295);seed=[BigInt(0),BigInt(0)];constructor(t){this.seed=t}static create(t){return new n(n.upgradeSeedTo128bit(t))}static mixStafford13(t){return t=(t^t>>n.BIGINT_30)*n.STAFFORD_1&n.MAX_ULONG,t=(t^t>>n.BIGINT_27)*n.STAFFORD_2&n.MAX_ULONG,(t^t>>n.BIGINT_31)&n.MAX_ULONG}static upgradeSeedTo128bit(t){t<0&&(t+=n.POW2_60);let e=t^n.SILVER_RATIO_64,i=e+n.GOLDEN_RATIO_64&n.MAX_ULONG;return[n.mixStafford13(e),n.mixStafford13(i)]}static rotateLeft(t,e){return t<<e&n.MAX_ULONG|t>>n.BIGINT_64-e}setSeed(t){this.seed=n.upgradeSeedTo128bit(t)}fork(){return new n([this.next(),this.next()])}forkPositional(){return new Wo(this.next(),this.next())}next(){let t=this.seed[0],e=this.seed[1],i=n.rotateLeft(t+e&n.MAX_ULONG,n.BIGINT_17)+t&n.MAX_ULONG;return e^=t,this.seed=[n.rotateLeft(t,n.BIGINT_49)^e^e<<n.BIGINT_21&n.MAX_ULONG,n.rotateLeft(e,n.BIGINT_28)],i}nextLong(){let t=this.next();return t>n.POW2_63&&(t-=n.POW2_60),t}consume(t){let e=this.seed[0],i=this.seed[1];for(let r=0;r<t;r+=1)i^=e,e=n.rotateLeft(e,n.BIGINT_49)^i^i<<n.BIGINT_21,i=n.rotateLeft(i,n.BIGINT_28);this.seed=[e,i]}nextBits(t){return this.next()>>BigInt(64-t)}nextInt(t){let e=this.next()&n.MAX_UINT;if(t){let i=BigInt(t),r=e*i,s=r&n.MAX_UINT;if(s<i){let o=((~i&n.MAX_UINT)+n.BIGINT_1)%i;for(;s<o;)e=this.next()&n.MAX_UINT,r=e*i,s=r&n.MAX_UINT}let a=r>>n.BIGINT_32;return Number(a)}else{let i=Number(e);return i>=2147483648&&(i-=4294967296),i}}nextFloat(){return Number(this.nextBits(24))*n.FLOAT_MULTIPLIER}nextDouble(){return Number(this.nextBits(53))*n.DOUBLE_MULTIPLIER}parityConfigString(){return"seedLo: "+this.seed[0]+", seedHi: "+this.seed[1]}},Wo=class{seedLo;seedHi;constructor(t,e){this.seedLo=t,this.seedHi=e}at(t,e,i){let s=Ss(t,e,i)^this.seedLo;return new tr([s,this.seedHi])}fromHashOf(t){let e=(0,Gh.default)(t,{asBytes:!0}),i=zo(e[0],e[1],e[2],e[3],e[4],e[5],e[6],e[7]),r=zo(e[8],e[9],e[10],e[11],e[12],e[13],e[14],e[15]);return new tr([i^this.seedLo,r^this.seedHi])}seedKey(){return[this.seedLo,this.seedHi]}};function Vh(n){var t=n.slice(0,2);return t.length===2&&t[0]===31&&t[1]===139}function Hh(n){let t=n.slice(0,2);return t.length===2&&t[0]===120&&(t[1]===1||t[1]===94||t[1]===156||t[2]===218)}function Wh(n){let t=n.slice(0,8),e=new DataView(t.buffer,t.byteOffset),i=e.getUint32(0,!0),r=e.getUint32(4,!0);if(t.length===8&&i>0&&i<100&&r===n.byteLength-8)return i}function Xh(n){var t=[],e,i;for(e=0;e<n.length;e++)i=n.charCodeAt(e),i<128?t.push(i):i<2048?(t.push(192|i>>6),t.push(128|i&63)):i<65536?(t.push(224|i>>12),t.push(128|i>>6&63),t.push(128|i&63)):(t.push(240|i>>18&7),t.push(128|i>>12&63),t.push(128|i>>6&63),t.push(128|i&63));return t}function qh(n){var t=[],e;for(e=0;e<n.length;e++)(n[e]&128)===0?t.push(n[e]&127):e+1<n.length&&(n[e]&224)===192&&(n[e+1]&192)===128?t.push((n[e]&31)<<6|n[e+1]&63):e+2<n.length&&(n[e]&240)===224&&(n[e+1]&192)===128&&(n[e+2]&192)===128?t.push((n[e]&15)<<12|(n[e+1]&63)<<6|n[e+2]&63):e+3<n.length&&(n[e]&248)===240&&(n[e+1]&192)===128&&(n[e+2]&192)===128&&(n[e+3]&192)===128&&t.push((n[e]&7)<<18|(n[e+1]&63)<<12|(n[e+2]&63)<<6|n[e+3]&63);return String.fromCharCode.apply(null,t)}var As=class{littleEndian;offset;array;view;constructor(t,e){this.littleEndian=e?.littleEndian??!1,this.offset=e?.offset??0,this.array=t instanceof Uint8Array?t:new Uint8Array(t),this.view=new DataView(this.array.buffer,this.array.byteOffset)}readNumber(t,e){let i=this.view[t](this.offset,this.littleEndian);return this.offset+=e,i}readByte=this.readNumber.bind(this,"getInt8",1);readShort=this.readNumber.bind(this,"getInt16",2);readInt=this.readNumber.bind(this,"getInt32",4);readFloat=this.readNumber.bind(this,"getFloat32",4);readDouble=this.readNumber.bind(this,"getFloat64",8);readBytes(t){let e=this.array.slice(this.offset,this.offset+t);return this.offset+=t,e}readString(){let t=this.readShort(),e=this.readBytes(t);return qh(e)}};var Ts=class{littleEndian;offset;buffer;array;view;constructor(t){this.littleEndian=t?.littleEndian??!1,this.offset=t?.offset??0,this.buffer=new ArrayBuffer(t?.initialSize??1024),this.array=new Uint8Array(this.buffer),this.view=new DataView(this.buffer)}accommodate(t){let e=this.offset+t;if(this.buffer.byteLength>=e)return;let i=this.buffer.byteLength;for(;i<e;)i*=2;let r=new ArrayBuffer(i),s=new Uint8Array(r);s.set(this.array),this.offset>this.buffer.byteLength&&s.fill(0,this.buffer.byteLength,this.offset),this.buffer=r,this.view=new DataView(r),this.array=s}writeNumber(t,e,i){this.accommodate(e),this.view[t](this.offset,i,this.littleEndian),this.offset+=e}writeByte=this.writeNumber.bind(this,"setInt8",1);writeShort=this.writeNumber.bind(this,"setInt16",2);writeInt=this.writeNumber.bind(this,"setInt32",4);writeFloat=this.writeNumber.bind(this,"setFloat32",4);writeDouble=this.writeNumber.bind(this,"setFloat64",8);writeBytes(t){this.accommodate(t.length),this.array.set(t,this.offset),this.offset+=t.length}writeString(t){let e=Xh(t);this.writeShort(e.length),this.writeBytes(e)}getData(){return this.accommodate(0),this.array.slice(0,this.offset)}};function Si(n){let t=n.length;for(;--t>=0;)n[t]=0}var Kv=0,Lu=1,Qv=2,jv=3,ty=258,pl=29,pr=256,or=pr+1+pl,_i=30,ml=19,Du=2*or+1,Tn=15,Xo=16,ey=7,gl=256,Uu=16,Fu=17,Ou=18,sl=new Uint8Array([0,0,0,0,0,0,0,0,1,1,1,1,2,2,2,2,3,3,3,3,4,4,4,4,5,5,5,5,0]),Ls=new Uint8Array([0,0,0,0,1,1,2,2,3,3,4,4,5,5,6,6,7,7,8,8,9,9,10,10,11,11,12,12,13,13]),ny=new Uint8Array([0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,2,3,7]),Bu=new Uint8Array([16,17,18,0,8,7,9,6,10,5,11,4,12,3,13,2,14,1,15]),iy=512,Qe=new Array((or+2)*2);Si(Qe);var rr=new Array(_i*2);Si(rr);var lr=new Array(iy);Si(lr);var cr=new Array(ty-jv+1);Si(cr);var _l=new Array(pl);Si(_l);var Ds=new Array(_i);Si(Ds);function qo(n,t,e,i,r){this.static_tree=n,this.extra_bits=t,this.extra_base=e,this.elems=i,this.max_length=r,this.has_stree=n&&n.length}var zu,ku,Gu;function Yo(n,t){this.dyn_tree=n,this.max_code=0,this.stat_desc=t}var Vu=n=>n<256?lr[n]:lr[256+(n>>>7)],hr=(n,t)=>{n.pending_buf[n.pending++]=t&255,n.pending_buf[n.pending++]=t>>>8&255},re=(n,t,e)=>{n.bi_valid>Xo-e?(n.bi_buf|=t<<n.bi_valid&65535,hr(n,n.bi_buf),n.bi_buf=t>>Xo-n.bi_valid,n.bi_valid+=e-Xo):(n.bi_buf|=t<<n.bi_valid&65535,n.bi_valid+=e)},Be=(n,t,e)=>{re(n,e[t*2],e[t*2+1])},Hu=(n,t)=>{let e=0;do e|=n&1,n>>>=1,e<<=1;while(--t>0);return e>>>1},ry=n=>{n.bi_valid===16?(hr(n,n.bi_buf),n.bi_buf=0,n.bi_valid=0):n.bi_valid>=8&&(n.pending_buf[n.pending++]=n.bi_buf&255,n.bi_buf>>=8,n.bi_valid-=8)},sy=(n,t)=>{let e=t.dyn_tree,i=t.max_code,r=t.stat_desc.static_tree,s=t.stat_desc.has_stree,a=t.stat_desc.extra_bits,o=t.stat_desc.extra_base,h=t.stat_desc.max_length,l,c,u,d,f,p,m=0;for(d=0;d<=Tn;d++)n.bl_count[d]=0;for(e[n.heap[n.heap_max]*2+1]=0,l=n.heap_max+1;l<Du;l++)c=n.heap[l],d=e[e[c*2+1]*2+1]+1,d>h&&(d=h,m++),e[c*2+1]=d,!(c>i)&&(n.bl_count[d]++,f=0,c>=o&&(f=a[c-o]),p=e[c*2],n.opt_len+=p*(d+f),s&&(n.static_len+=p*(r[c*2+1]+f)));if(m!==0){do{for(d=h-1;n.bl_count[d]===0;)d--;n.bl_count[d]--,n.bl_count[d+1]+=2,n.bl_count[h]--,m-=2}while(m>0);for(d=h;d!==0;d--)for(c=n.bl_count[d];c!==0;)u=n.heap[--l],!(u>i)&&(e[u*2+1]!==d&&(n.opt_len+=(d-e[u*2+1])*e[u*2],e[u*2+1]=d),c--)}},Wu=(n,t,e)=>{let i=new Array(Tn+1),r=0,s,a;for(s=1;s<=Tn;s++)r=r+e[s-1]<<1,i[s]=r;for(a=0;a<=t;a++){let o=n[a*2+1];o!==0&&(n[a*2]=Hu(i[o]++,o))}},ay=()=>{let n,t,e,i,r,s=new Array(Tn+1);for(e=0,i=0;i<pl-1;i++)for(_l[i]=e,n=0;n<1<<sl[i];n++)cr[e++]=i;for(cr[e-1]=i,r=0,i=0;i<16;i++)for(Ds[i]=r,n=0;n<1<<Ls[i];n++)lr[r++]=i;for(r>>=7;i<_i;i++)for(Ds[i]=r<<7,n=0;n<1<<Ls[i]-7;n++)lr[256+r++]=i;for(t=0;t<=Tn;t++)s[t]=0;for(n=0;n<=143;)Qe[n*2+1]=8,n++,s[8]++;for(;n<=255;)Qe[n*2+1]=9,n++,s[9]++;for(;n<=279;)Qe[n*2+1]=7,n++,s[7]++;for(;n<=287;)Qe[n*2+1]=8,n++,s[8]++;for(Wu(Qe,or+1,s),n=0;n<_i;n++)rr[n*2+1]=5,rr[n*2]=Hu(n,5);zu=new qo(Qe,sl,pr+1,or,Tn),ku=new qo(rr,Ls,0,_i,Tn),Gu=new qo(new Array(0),ny,0,ml,ey)},Xu=n=>{let t;for(t=0;t<or;t++)n.dyn_ltree[t*2]=0;for(t=0;t<_i;t++)n.dyn_dtree[t*2]=0;for(t=0;t<ml;t++)n.bl_tree[t*2]=0;n.dyn_ltree[gl*2]=1,n.opt_len=n.static_len=0,n.sym_next=n.matches=0},qu=n=>{n.bi_valid>8?hr(n,n.bi_buf):n.bi_valid>0&&(n.pending_buf[n.pending++]=n.bi_buf),n.bi_buf=0,n.bi_valid=0},Yh=(n,t,e,i)=>{let r=t*2,s=e*2;return n[r]<n[s]||n[r]===n[s]&&i[t]<=i[e]},Zo=(n,t,e)=>{let i=n.heap[e],r=e<<1;for(;r<=n.heap_len&&(r<n.heap_len&&Yh(t,n.heap[r+1],n.heap[r],n.depth)&&r++,!Yh(t,i,n.heap[r],n.depth));)n.heap[e]=n.heap[r],e=r,r<<=1;n.heap[e]=i},Zh=(n,t,e)=>{let i,r,s=0,a,o;if(n.sym_next!==0)do i=n.pending_buf[n.sym_buf+s++]&255,i+=(n.pending_buf[n.sym_buf+s++]&255)<<8,r=n.pending_buf[n.sym_buf+s++],i===0?Be(n,r,t):(a=cr[r],Be(n,a+pr+1,t),o=sl[a],o!==0&&(r-=_l[a],re(n,r,o)),i--,a=Vu(i),Be(n,a,e),o=Ls[a],o!==0&&(i-=Ds[a],re(n,i,o)));while(s<n.sym_next);Be(n,gl,t)},al=(n,t)=>{let e=t.dyn_tree,i=t.stat_desc.static_tree,r=t.stat_desc.has_stree,s=t.stat_desc.elems,a,o,h=-1,l;for(n.heap_len=0,n.heap_max=Du,a=0;a<s;a++)e[a*2]!==0?(n.heap[++n.heap_len]=h=a,n.depth[a]=0):e[a*2+1]=0;for(;n.heap_len<2;)l=n.heap[++n.heap_len]=h<2?++h:0,e[l*2]=1,n.depth[l]=0,n.opt_len--,r&&(n.static_len-=i[l*2+1]);for(t.max_code=h,a=n.heap_len>>1;a>=1;a--)Zo(n,e,a);l=s;do a=n.heap[1],n.heap[1]=n.heap[n.heap_len--],Zo(n,e,1),o=n.heap[1],n.heap[--n.heap_max]=a,n.heap[--n.heap_max]=o,e[l*2]=e[a*2]+e[o*2],n.depth[l]=(n.depth[a]>=n.depth[o]?n.depth[a]:n.depth[o])+1,e[a*2+1]=e[o*2+1]=l,n.heap[1]=l++,Zo(n,e,1);while(n.heap_len>=2);n.heap[--n.heap_max]=n.heap[1],sy(n,t),Wu(e,h,n.bl_count)},Jh=(n,t,e)=>{let i,r=-1,s,a=t[1],o=0,h=7,l=4;for(a===0&&(h=138,l=3),t[(e+1)*2+1]=65535,i=0;i<=e;i++)s=a,a=t[(i+1)*2+1],!(++o<h&&s===a)&&(o<l?n.bl_tree[s*2]+=o:s!==0?(s!==r&&n.bl_tree[s*2]++,n.bl_tree[Uu*2]++):o<=10?n.bl_tree[Fu*2]++:n.bl_tree[Ou*2]++,o=0,r=s,a===0?(h=138,l=3):s===a?(h=6,l=3):(h=7,l=4))},$h=(n,t,e)=>{let i,r=-1,s,a=t[1],o=0,h=7,l=4;for(a===0&&(h=138,l=3),i=0;i<=e;i++)if(s=a,a=t[(i+1)*2+1],!(++o<h&&s===a)){if(o<l)do Be(n,s,n.bl_tree);while(--o!==0);else s!==0?(s!==r&&(Be(n,s,n.bl_tree),o--),Be(n,Uu,n.bl_tree),re(n,o-3,2)):o<=10?(Be(n,Fu,n.bl_tree),re(n,o-3,3)):(Be(n,Ou,n.bl_tree),re(n,o-11,7));o=0,r=s,a===0?(h=138,l=3):s===a?(h=6,l=3):(h=7,l=4)}},oy=n=>{let t;for(Jh(n,n.dyn_ltree,n.l_desc.max_code),Jh(n,n.dyn_dtree,n.d_desc.max_code),al(n,n.bl_desc),t=ml-1;t>=3&&n.bl_tree[Bu[t]*2+1]===0;t--);return n.opt_len+=3*(t+1)+5+5+4,t},ly=(n,t,e,i)=>{let r;for(re(n,t-257,5),re(n,e-1,5),re(n,i-4,4),r=0;r<i;r++)re(n,n.bl_tree[Bu[r]*2+1],3);$h(n,n.dyn_ltree,t-1),$h(n,n.dyn_dtree,e-1)},cy=n=>{let t=4093624447,e;for(e=0;e<=31;e++,t>>>=1)if(t&1&&n.dyn_ltree[e*2]!==0)return 0;if(n.dyn_ltree[18]!==0||n.dyn_ltree[20]!==0||n.dyn_ltree[26]!==0)return 1;for(e=32;e<pr;e++)if(n.dyn_ltree[e*2]!==0)return 1;return 0},Kh=!1,hy=n=>{Kh||(ay(),Kh=!0),n.l_desc=new Yo(n.dyn_ltree,zu),n.d_desc=new Yo(n.dyn_dtree,ku),n.bl_desc=new Yo(n.bl_tree,Gu),n.bi_buf=0,n.bi_valid=0,Xu(n)},Yu=(n,t,e,i)=>{re(n,(Kv<<1)+(i?1:0),3),qu(n),hr(n,e),hr(n,~e),e&&n.pending_buf.set(n.window.subarray(t,t+e),n.pending),n.pending+=e},uy=n=>{re(n,Lu<<1,3),Be(n,gl,Qe),ry(n)},fy=(n,t,e,i)=>{let r,s,a=0;n.level>0?(n.strm.data_type===2&&(n.strm.data_type=cy(n)),al(n,n.l_desc),al(n,n.d_desc),a=oy(n),r=n.opt_len+3+7>>>3,s=n.static_len+3+7>>>3,s<=r&&(r=s)):r=s=e+5,e+4<=r&&t!==-1?Yu(n,t,e,i):n.strategy===4||s===r?(re(n,(Lu<<1)+(i?1:0),3),Zh(n,Qe,rr)):(re(n,(Qv<<1)+(i?1:0),3),ly(n,n.l_desc.max_code+1,n.d_desc.max_code+1,a+1),Zh(n,n.dyn_ltree,n.dyn_dtree)),Xu(n),i&&qu(n)},dy=(n,t,e)=>(n.pending_buf[n.sym_buf+n.sym_next++]=t,n.pending_buf[n.sym_buf+n.sym_next++]=t>>8,n.pending_buf[n.sym_buf+n.sym_next++]=e,t===0?n.dyn_ltree[e*2]++:(n.matches++,t--,n.dyn_ltree[(cr[e]+pr+1)*2]++,n.dyn_dtree[Vu(t)*2]++),n.sym_next===n.sym_end),py=hy,my=Yu,gy=fy,_y=dy,xy=uy,vy={_tr_init:py,_tr_stored_block:my,_tr_flush_block:gy,_tr_tally:_y,_tr_align:xy},yy=(n,t,e,i)=>{let r=n&65535|0,s=n>>>16&65535|0,a=0;for(;e!==0;){a=e>2e3?2e3:e,e-=a;do r=r+t[i++]|0,s=s+r|0;while(--a);r%=65521,s%=65521}return r|s<<16|0},ur=yy,Sy=()=>{let n,t=[];for(var e=0;e<256;e++){n=e;for(var i=0;i<8;i++)n=n&1?3988292384^n>>>1:n>>>1;t[e]=n}return t},My=new Uint32Array(Sy()),by=(n,t,e,i)=>{let r=My,s=i+e;n^=-1;for(let a=i;a<s;a++)n=n>>>8^r[(n^t[a])&255];return n^-1},kt=by,In={2:"need dictionary",1:"stream end",0:"","-1":"file error","-2":"stream error","-3":"data error","-4":"insufficient memory","-5":"buffer error","-6":"incompatible version"},Dn={Z_NO_FLUSH:0,Z_PARTIAL_FLUSH:1,Z_SYNC_FLUSH:2,Z_FULL_FLUSH:3,Z_FINISH:4,Z_BLOCK:5,Z_TREES:6,Z_OK:0,Z_STREAM_END:1,Z_NEED_DICT:2,Z_ERRNO:-1,Z_STREAM_ERROR:-2,Z_DATA_ERROR:-3,Z_MEM_ERROR:-4,Z_BUF_ERROR:-5,Z_NO_COMPRESSION:0,Z_BEST_SPEED:1,Z_BEST_COMPRESSION:9,Z_DEFAULT_COMPRESSION:-1,Z_FILTERED:1,Z_HUFFMAN_ONLY:2,Z_RLE:3,Z_FIXED:4,Z_DEFAULT_STRATEGY:0,Z_BINARY:0,Z_TEXT:1,Z_UNKNOWN:2,Z_DEFLATED:8},{_tr_init:wy,_tr_stored_block:ol,_tr_flush_block:Ey,_tr_tally:gn,_tr_align:Ay}=vy,{Z_NO_FLUSH:_n,Z_PARTIAL_FLUSH:Ty,Z_FULL_FLUSH:Ry,Z_FINISH:ye,Z_BLOCK:Qh,Z_OK:Wt,Z_STREAM_END:jh,Z_STREAM_ERROR:ze,Z_DATA_ERROR:Cy,Z_BUF_ERROR:Jo,Z_DEFAULT_COMPRESSION:Iy,Z_FILTERED:Py,Z_HUFFMAN_ONLY:Rs,Z_RLE:Ny,Z_FIXED:Ly,Z_DEFAULT_STRATEGY:Dy,Z_UNKNOWN:Uy,Z_DEFLATED:Os}=Dn,Fy=9,Oy=15,By=8,zy=29,ky=256,ll=ky+1+zy,Gy=30,Vy=19,Hy=2*ll+1,Wy=15,ct=3,mn=258,ke=mn+ct+1,Xy=32,vi=42,xl=57,cl=69,hl=73,ul=91,fl=103,Rn=113,nr=666,ne=1,Mi=2,Pn=3,bi=4,qy=3,Cn=(n,t)=>(n.msg=In[t],t),tu=n=>n*2-(n>4?9:0),pn=n=>{let t=n.length;for(;--t>=0;)n[t]=0},Yy=n=>{let t,e,i,r=n.w_size;t=n.hash_size,i=t;do e=n.head[--i],n.head[i]=e>=r?e-r:0;while(--t);t=r,i=t;do e=n.prev[--i],n.prev[i]=e>=r?e-r:0;while(--t)},vl=(n,t,e)=>(t<<n.hash_shift^e)&n.hash_mask,Nn=(n,t)=>{let e;if(n.legacy_hash)e=n.ins_h=vl(n,n.ins_h,n.window[t+ct-1]);else{let r=n.window,s=r[t]|r[t+1]<<8|r[t+2]<<16|r[t+3]<<24;e=n.ins_h=Math.imul(s,66521)+66521>>>16&n.hash_mask}let i=n.prev[t&n.w_mask]=n.head[e];return n.head[e]=t,i},ce=n=>{let t=n.state,e=t.pending;e>n.avail_out&&(e=n.avail_out),e!==0&&(n.output.set(t.pending_buf.subarray(t.pending_out,t.pending_out+e),n.next_out),n.next_out+=e,t.pending_out+=e,n.total_out+=e,n.avail_out-=e,t.pending-=e,t.pending===0&&(t.pending_out=0))},he=(n,t)=>{Ey(n,n.block_start>=0?n.block_start:-1,n.strstart-n.block_start,t),n.block_start=n.strstart,ce(n.strm)},ft=(n,t)=>{n.pending_buf[n.pending++]=t},er=(n,t)=>{n.pending_buf[n.pending++]=t>>>8&255,n.pending_buf[n.pending++]=t&255},dl=(n,t,e,i)=>{let r=n.avail_in;return r>i&&(r=i),r===0?0:(n.avail_in-=r,t.set(n.input.subarray(n.next_in,n.next_in+r),e),n.state.wrap===1?n.adler=ur(n.adler,t,r,e):n.state.wrap===2&&(n.adler=kt(n.adler,t,r,e)),n.next_in+=r,n.total_in+=r,r)},Zu=(n,t)=>{let e=n.max_chain_length,i=n.strstart,r,s,a=n.prev_length,o=n.nice_match,h=n.strstart>n.w_size-ke?n.strstart-(n.w_size-ke):0,l=n.window,c=n.w_mask,u=n.prev,d=n.strstart+mn,f=l[i+a-1],p=l[i+a];n.prev_length>=n.good_match&&(e>>=2),o>n.lookahead&&(o=n.lookahead);do if(r=t,!(l[r+a]!==p||l[r+a-1]!==f||l[r]!==l[i]||l[++r]!==l[i+1])){i+=2,r++;do;while(l[++i]===l[++r]&&l[++i]===l[++r]&&l[++i]===l[++r]&&l[++i]===l[++r]&&l[++i]===l[++r]&&l[++i]===l[++r]&&l[++i]===l[++r]&&l[++i]===l[++r]&&i<d);if(s=mn-(d-i),i=d-mn,s>a){if(n.match_start=t,a=s,s>=o)break;f=l[i+a-1],p=l[i+a]}}while((t=u[t&c])>h&&--e!==0);return a<=n.lookahead?a:n.lookahead},yi=n=>{let t=n.w_size,e,i,r;do{if(i=n.window_size-n.lookahead-n.strstart,n.strstart>=t+(t-ke)&&(n.window.set(n.window.subarray(t,t+t-i),0),n.match_start-=t,n.strstart-=t,n.block_start-=t,n.insert>n.strstart&&(n.insert=n.strstart),Yy(n),i+=t),n.strm.avail_in===0)break;if(e=dl(n.strm,n.window,n.strstart+n.lookahead,i),n.lookahead+=e,n.legacy_hash){if(n.lookahead+n.insert>=ct)for(r=n.strstart-n.insert,n.ins_h=n.window[r],n.ins_h=vl(n,n.ins_h,n.window[r+1]);n.insert&&(Nn(n,r),r++,n.insert--,!(n.lookahead+n.insert<ct)););}else if(n.lookahead+n.insert>ct)for(r=n.strstart-n.insert;n.insert&&(Nn(n,r),r++,n.insert--,!(n.lookahead+n.insert<=ct)););}while(n.lookahead<ke&&n.strm.avail_in!==0)},Ju=(n,t)=>{let e=n.pending_buf_size-5>n.w_size?n.w_size:n.pending_buf_size-5,i,r,s,a=0,o=n.strm.avail_in;do{if(i=65535,s=n.bi_valid+42>>3,n.strm.avail_out<s||(s=n.strm.avail_out-s,r=n.strstart-n.block_start,i>r+n.strm.avail_in&&(i=r+n.strm.avail_in),i>s&&(i=s),i<e&&(i===0&&t!==ye||t===_n||i!==r+n.strm.avail_in)))break;a=t===ye&&i===r+n.strm.avail_in?1:0,ol(n,0,0,a),n.pending_buf[n.pending-4]=i,n.pending_buf[n.pending-3]=i>>8,n.pending_buf[n.pending-2]=~i,n.pending_buf[n.pending-1]=~i>>8,ce(n.strm),r&&(r>i&&(r=i),n.strm.output.set(n.window.subarray(n.block_start,n.block_start+r),n.strm.next_out),n.strm.next_out+=r,n.strm.avail_out-=r,n.strm.total_out+=r,n.block_start+=r,i-=r),i&&(dl(n.strm,n.strm.output,n.strm.next_out,i),n.strm.next_out+=i,n.strm.avail_out-=i,n.strm.total_out+=i)}while(a===0);return o-=n.strm.avail_in,o&&(o>=n.w_size?(n.matches=2,n.window.set(n.strm.input.subarray(n.strm.next_in-n.w_size,n.strm.next_in),0),n.strstart=n.w_size,n.insert=n.strstart):(n.window_size-n.strstart<=o&&(n.strstart-=n.w_size,n.window.set(n.window.subarray(n.w_size,n.w_size+n.strstart),0),n.matches<2&&n.matches++,n.insert>n.strstart&&(n.insert=n.strstart)),n.window.set(n.strm.input.subarray(n.strm.next_in-o,n.strm.next_in),n.strstart),n.strstart+=o,n.insert+=o>n.w_size-n.insert?n.w_size-n.insert:o),n.block_start=n.strstart),n.high_water<n.strstart&&(n.high_water=n.strstart),a?bi:t!==_n&&t!==ye&&n.strm.avail_in===0&&n.strstart===n.block_start?Mi:(s=n.window_size-n.strstart,n.strm.avail_in>s&&n.block_start>=n.w_size&&(n.block_start-=n.w_size,n.strstart-=n.w_size,n.window.set(n.window.subarray(n.w_size,n.w_size+n.strstart),0),n.matches<2&&n.matches++,s+=n.w_size,n.insert>n.strstart&&(n.insert=n.strstart)),s>n.strm.avail_in&&(s=n.strm.avail_in),s&&(dl(n.strm,n.window,n.strstart,s),n.strstart+=s,n.insert+=s>n.w_size-n.insert?n.w_size-n.insert:s),n.high_water<n.strstart&&(n.high_water=n.strstart),s=n.bi_valid+42>>3,s=n.pending_buf_size-s>65535?65535:n.pending_buf_size-s,e=s>n.w_size?n.w_size:s,r=n.strstart-n.block_start,(r>=e||(r||t===ye)&&t!==_n&&n.strm.avail_in===0&&r<=s)&&(i=r>s?s:r,a=t===ye&&n.strm.avail_in===0&&i===r?1:0,ol(n,n.block_start,i,a),n.block_start+=i,ce(n.strm)),a?Pn:ne)},$o=(n,t)=>{let e,i;for(;;){if(n.lookahead<ke){if(yi(n),n.lookahead<ke&&t===_n)return ne;if(n.lookahead===0)break}if(e=0,n.lookahead>=ct&&(e=Nn(n,n.strstart)),e!==0&&n.strstart-e<=n.w_size-ke&&(n.match_length=Zu(n,e)),n.match_length>=ct)if(i=gn(n,n.strstart-n.match_start,n.match_length-ct),n.lookahead-=n.match_length,n.match_length<=n.max_lazy_match&&n.lookahead>=ct){n.match_length--;do n.strstart++,e=Nn(n,n.strstart);while(--n.match_length!==0);n.strstart++}else n.strstart+=n.match_length,n.match_length=0,n.legacy_hash&&(n.ins_h=n.window[n.strstart],n.ins_h=vl(n,n.ins_h,n.window[n.strstart+1]));else i=gn(n,0,n.window[n.strstart]),n.lookahead--,n.strstart++;if(i&&(he(n,!1),n.strm.avail_out===0))return ne}return n.insert=n.strstart<ct-1?n.strstart:ct-1,t===ye?(he(n,!0),n.strm.avail_out===0?Pn:bi):n.sym_next&&(he(n,!1),n.strm.avail_out===0)?ne:Mi},mi=(n,t)=>{let e,i,r;for(;;){if(n.lookahead<ke){if(yi(n),n.lookahead<ke&&t===_n)return ne;if(n.lookahead===0)break}if(e=0,n.lookahead>=ct&&(e=Nn(n,n.strstart)),n.prev_length=n.match_length,n.prev_match=n.match_start,n.match_length=ct-1,e!==0&&n.prev_length<n.max_lazy_match&&n.strstart-e<=n.w_size-ke&&(n.match_length=Zu(n,e),n.match_length<=5&&(n.strategy===Py||n.match_length===ct&&n.strstart-n.match_start>4096)&&(n.match_length=ct-1)),n.prev_length>=ct&&n.match_length<=n.prev_length){r=n.strstart+n.lookahead-ct,i=gn(n,n.strstart-1-n.prev_match,n.prev_length-ct),n.lookahead-=n.prev_length-1,n.prev_length-=2;do++n.strstart<=r&&(e=Nn(n,n.strstart));while(--n.prev_length!==0);if(n.match_available=0,n.match_length=ct-1,n.strstart++,i&&(he(n,!1),n.strm.avail_out===0))return ne}else if(n.match_available){if(i=gn(n,0,n.window[n.strstart-1]),i&&he(n,!1),n.strstart++,n.lookahead--,n.strm.avail_out===0)return ne}else n.match_available=1,n.strstart++,n.lookahead--}return n.match_available&&(i=gn(n,0,n.window[n.strstart-1]),n.match_available=0),n.insert=n.strstart<ct-1?n.strstart:ct-1,t===ye?(he(n,!0),n.strm.avail_out===0?Pn:bi):n.sym_next&&(he(n,!1),n.strm.avail_out===0)?ne:Mi},Zy=(n,t)=>{let e,i,r,s,a=n.window;for(;;){if(n.lookahead<=mn){if(yi(n),n.lookahead<=mn&&t===_n)return ne;if(n.lookahead===0)break}if(n.match_length=0,n.lookahead>=ct&&n.strstart>0&&(r=n.strstart-1,i=a[r],i===a[++r]&&i===a[++r]&&i===a[++r])){s=n.strstart+mn;do;while(i===a[++r]&&i===a[++r]&&i===a[++r]&&i===a[++r]&&i===a[++r]&&i===a[++r]&&i===a[++r]&&i===a[++r]&&r<s);n.match_length=mn-(s-r),n.match_length>n.lookahead&&(n.match_length=n.lookahead)}if(n.match_length>=ct?(e=gn(n,1,n.match_length-ct),n.lookahead-=n.match_length,n.strstart+=n.match_length,n.match_length=0):(e=gn(n,0,n.window[n.strstart]),n.lookahead--,n.strstart++),e&&(he(n,!1),n.strm.avail_out===0))return ne}return n.insert=0,t===ye?(he(n,!0),n.strm.avail_out===0?Pn:bi):n.sym_next&&(he(n,!1),n.strm.avail_out===0)?ne:Mi},Jy=(n,t)=>{let e;for(;;){if(n.lookahead===0&&(yi(n),n.lookahead===0)){if(t===_n)return ne;break}if(n.match_length=0,e=gn(n,0,n.window[n.strstart]),n.lookahead--,n.strstart++,e&&(he(n,!1),n.strm.avail_out===0))return ne}return n.insert=0,t===ye?(he(n,!0),n.strm.avail_out===0?Pn:bi):n.sym_next&&(he(n,!1),n.strm.avail_out===0)?ne:Mi};function Fe(n,t,e,i,r){this.good_length=n,this.max_lazy=t,this.nice_length=e,this.max_chain=i,this.func=r}var ir=[new Fe(0,0,0,0,Ju),new Fe(4,4,8,4,$o),new Fe(4,5,16,8,$o),new Fe(4,6,32,32,$o),new Fe(4,4,16,16,mi),new Fe(8,16,32,32,mi),new Fe(8,16,128,128,mi),new Fe(8,32,128,256,mi),new Fe(32,128,258,1024,mi),new Fe(32,258,258,4096,mi)],$y=n=>{n.window_size=2*n.w_size,pn(n.head),n.max_lazy_match=ir[n.level].max_lazy,n.good_match=ir[n.level].good_length,n.nice_match=ir[n.level].nice_length,n.max_chain_length=ir[n.level].max_chain,n.strstart=0,n.block_start=0,n.lookahead=0,n.insert=0,n.match_length=n.prev_length=ct-1,n.match_available=0,n.ins_h=0};function Ky(){this.strm=null,this.status=0,this.pending_buf=null,this.pending_buf_size=0,this.pending_out=0,this.pending=0,this.wrap=0,this.gzhead=null,this.gzindex=0,this.method=Os,this.last_flush=-1,this.w_size=0,this.w_bits=0,this.w_mask=0,this.window=null,this.window_size=0,this.prev=null,this.head=null,this.ins_h=0,this.legacy_hash=0,this.hash_size=0,this.hash_bits=0,this.hash_mask=0,this.hash_shift=0,this.block_start=0,this.match_length=0,this.prev_match=0,this.match_available=0,this.strstart=0,this.match_start=0,this.lookahead=0,this.prev_length=0,this.max_chain_length=0,this.max_lazy_match=0,this.level=0,this.strategy=0,this.good_match=0,this.nice_match=0,this.dyn_ltree=new Uint16Array(Hy*2),this.dyn_dtree=new Uint16Array((2*Gy+1)*2),this.bl_tree=new Uint16Array((2*Vy+1)*2),pn(this.dyn_ltree),pn(this.dyn_dtree),pn(this.bl_tree),this.l_desc=null,this.d_desc=null,this.bl_desc=null,this.bl_count=new Uint16Array(Wy+1),this.heap=new Uint16Array(2*ll+1),pn(this.heap),this.heap_len=0,this.heap_max=0,this.depth=new Uint16Array(2*ll+1),pn(this.depth),this.sym_buf=0,this.lit_bufsize=0,this.sym_next=0,this.sym_end=0,this.opt_len=0,this.static_len=0,this.matches=0,this.insert=0,this.bi_buf=0,this.bi_valid=0}var mr=n=>{if(!n)return 1;let t=n.state;return!t||t.strm!==n||t.status!==vi&&t.status!==xl&&t.status!==cl&&t.status!==hl&&t.status!==ul&&t.status!==fl&&t.status!==Rn&&t.status!==nr?1:0},$u=n=>{if(mr(n))return Cn(n,ze);n.total_in=n.total_out=0,n.data_type=Uy;let t=n.state;return t.pending=0,t.pending_out=0,t.wrap<0&&(t.wrap=-t.wrap),t.status=t.wrap===2?xl:t.wrap?vi:Rn,n.adler=t.wrap===2?0:1,t.last_flush=-2,wy(t),Wt},Ku=n=>{let t=$u(n);return t===Wt&&$y(n.state),t},Qy=(n,t)=>mr(n)||n.state.wrap!==2?ze:(n.state.gzhead=t,Wt),Qu=(n,t,e,i,r,s,a)=>{if(!n)return ze;let o=1;if(t===Iy&&(t=6),i<0?(o=0,i=-i):i>15&&(o=2,i-=16),r<1||r>Fy||e!==Os||i<8||i>15||t<0||t>9||s<0||s>Ly||i===8&&o!==1)return Cn(n,ze);i===8&&(i=9);let h=new Ky;return n.state=h,h.strm=n,h.status=vi,h.wrap=o,h.gzhead=null,h.w_bits=i,h.w_size=1<<h.w_bits,h.w_mask=h.w_size-1,h.legacy_hash=a?1:0,h.hash_bits=r+7,!h.legacy_hash&&h.hash_bits<15&&(h.hash_bits=15),h.hash_size=1<<h.hash_bits,h.hash_mask=h.hash_size-1,h.hash_shift=~~((h.hash_bits+ct-1)/ct),h.window=new Uint8Array(h.w_size*2),h.head=new Uint16Array(h.hash_size),h.prev=new Uint16Array(h.w_size),h.lit_bufsize=1<<r+6,h.pending_buf_size=h.lit_bufsize*4,h.pending_buf=new Uint8Array(h.pending_buf_size),h.sym_buf=h.lit_bufsize,h.sym_end=(h.lit_bufsize-1)*3,h.level=t,h.strategy=s,h.method=e,Ku(n)},jy=(n,t)=>Qu(n,t,Os,Oy,By,Dy),tS=(n,t)=>{if(mr(n)||t>Qh||t<0)return n?Cn(n,ze):ze;let e=n.state;if(!n.output||n.avail_in!==0&&!n.input||e.status===nr&&t!==ye)return Cn(n,n.avail_out===0?Jo:ze);let i=e.last_flush;if(e.last_flush=t,e.pending!==0){if(ce(n),n.avail_out===0)return e.last_flush=-1,Wt}else if(n.avail_in===0&&tu(t)<=tu(i)&&t!==ye)return Cn(n,Jo);if(e.status===nr&&n.avail_in!==0)return Cn(n,Jo);if(e.status===vi&&e.wrap===0&&(e.status=Rn),e.status===vi){let r=Os+(e.w_bits-8<<4)<<8,s=-1;if(e.strategy>=Rs||e.level<2?s=0:e.level<6?s=1:e.level===6?s=2:s=3,r|=s<<6,e.strstart!==0&&(r|=Xy),r+=31-r%31,er(e,r),e.strstart!==0&&(er(e,n.adler>>>16),er(e,n.adler&65535)),n.adler=1,e.status=Rn,ce(n),e.pending!==0)return e.last_flush=-1,Wt}if(e.status===xl){if(n.adler=0,ft(e,31),ft(e,139),ft(e,8),e.gzhead)ft(e,(e.gzhead.text?1:0)+(e.gzhead.hcrc?2:0)+(e.gzhead.extra?4:0)+(e.gzhead.name?8:0)+(e.gzhead.comment?16:0)),ft(e,e.gzhead.time&255),ft(e,e.gzhead.time>>8&255),ft(e,e.gzhead.time>>16&255),ft(e,e.gzhead.time>>24&255),ft(e,e.level===9?2:e.strategy>=Rs||e.level<2?4:0),ft(e,e.gzhead.os&255),e.gzhead.extra&&e.gzhead.extra.length&&(ft(e,e.gzhead.extra.length&255),ft(e,e.gzhead.extra.length>>8&255)),e.gzhead.hcrc&&(n.adler=kt(n.adler,e.pending_buf,e.pending,0)),e.gzindex=0,e.status=cl;else if(ft(e,0),ft(e,0),ft(e,0),ft(e,0),ft(e,0),ft(e,e.level===9?2:e.strategy>=Rs||e.level<2?4:0),ft(e,qy),e.status=Rn,ce(n),e.pending!==0)return e.last_flush=-1,Wt}if(e.status===cl){if(e.gzhead.extra){let r=e.pending,s=(e.gzhead.extra.length&65535)-e.gzindex;for(;e.pending+s>e.pending_buf_size;){let o=e.pending_buf_size-e.pending;if(e.pending_buf.set(e.gzhead.extra.subarray(e.gzindex,e.gzindex+o),e.pending),e.pending=e.pending_buf_size,e.gzhead.hcrc&&e.pending>r&&(n.adler=kt(n.adler,e.pending_buf,e.pending-r,r)),e.gzindex+=o,ce(n),e.pending!==0)return e.last_flush=-1,Wt;r=0,s-=o}let a=new Uint8Array(e.gzhead.extra);e.pending_buf.set(a.subarray(e.gzindex,e.gzindex+s),e.pending),e.pending+=s,e.gzhead.hcrc&&e.pending>r&&(n.adler=kt(n.adler,e.pending_buf,e.pending-r,r)),e.gzindex=0}e.status=hl}if(e.status===hl){if(e.gzhead.name){let r=e.pending,s;do{if(e.pending===e.pending_buf_size){if(e.gzhead.hcrc&&e.pending>r&&(n.adler=kt(n.adler,e.pending_buf,e.pending-r,r)),ce(n),e.pending!==0)return e.last_flush=-1,Wt;r=0}e.gzindex<e.gzhead.name.length?s=e.gzhead.name.charCodeAt(e.gzindex++)&255:s=0,ft(e,s)}while(s!==0);e.gzhead.hcrc&&e.pending>r&&(n.adler=kt(n.adler,e.pending_buf,e.pending-r,r)),e.gzindex=0}e.status=ul}if(e.status===ul){if(e.gzhead.comment){let r=e.pending,s;do{if(e.pending===e.pending_buf_size){if(e.gzhead.hcrc&&e.pending>r&&(n.adler=kt(n.adler,e.pending_buf,e.pending-r,r)),ce(n),e.pending!==0)return e.last_flush=-1,Wt;r=0}e.gzindex<e.gzhead.comment.length?s=e.gzhead.comment.charCodeAt(e.gzindex++)&255:s=0,ft(e,s)}while(s!==0);e.gzhead.hcrc&&e.pending>r&&(n.adler=kt(n.adler,e.pending_buf,e.pending-r,r))}e.status=fl}if(e.status===fl){if(e.gzhead.hcrc){if(e.pending+2>e.pending_buf_size&&(ce(n),e.pending!==0))return e.last_flush=-1,Wt;ft(e,n.adler&255),ft(e,n.adler>>8&255),n.adler=0}if(e.status=Rn,ce(n),e.pending!==0)return e.last_flush=-1,Wt}if(n.avail_in!==0||e.lookahead!==0||t!==_n&&e.status!==nr){let r=e.level===0?Ju(e,t):e.strategy===Rs?Jy(e,t):e.strategy===Ny?Zy(e,t):ir[e.level].func(e,t);if((r===Pn||r===bi)&&(e.status=nr),r===ne||r===Pn)return n.avail_out===0&&(e.last_flush=-1),Wt;if(r===Mi&&(t===Ty?Ay(e):t!==Qh&&(ol(e,0,0,!1),t===Ry&&(pn(e.head),e.lookahead===0&&(e.strstart=0,e.block_start=0,e.insert=0))),ce(n),n.avail_out===0))return e.last_flush=-1,Wt}return t!==ye?Wt:e.wrap<=0?jh:(e.wrap===2?(ft(e,n.adler&255),ft(e,n.adler>>8&255),ft(e,n.adler>>16&255),ft(e,n.adler>>24&255),ft(e,n.total_in&255),ft(e,n.total_in>>8&255),ft(e,n.total_in>>16&255),ft(e,n.total_in>>24&255)):(er(e,n.adler>>>16),er(e,n.adler&65535)),ce(n),e.wrap>0&&(e.wrap=-e.wrap),e.pending!==0?Wt:jh)},eS=n=>{if(mr(n))return ze;let t=n.state.status;return n.state=null,t===Rn?Cn(n,Cy):Wt},nS=(n,t)=>{let e=t.length;if(mr(n))return ze;let i=n.state,r=i.wrap;if(r===2||r===1&&i.status!==vi||i.lookahead)return ze;if(r===1&&(n.adler=ur(n.adler,t,e,0)),i.wrap=0,e>=i.w_size){r===0&&(pn(i.head),i.strstart=0,i.block_start=0,i.insert=0);let h=new Uint8Array(i.w_size);h.set(t.subarray(e-i.w_size,e),0),t=h,e=i.w_size}let s=n.avail_in,a=n.next_in,o=n.input;for(n.avail_in=e,n.next_in=0,n.input=t,yi(i);i.lookahead>=ct;){let h=i.strstart,l=i.lookahead-(ct-1);do Nn(i,h),h++;while(--l);i.strstart=h,i.lookahead=ct-1,yi(i)}return i.strstart+=i.lookahead,i.block_start=i.strstart,i.insert=i.lookahead,i.lookahead=0,i.match_length=i.prev_length=ct-1,i.match_available=0,n.next_in=a,n.input=o,n.avail_in=s,i.wrap=r,Wt},iS=jy,rS=Qu,sS=Ku,aS=$u,oS=Qy,lS=tS,cS=eS,hS=nS,uS="pako deflate (from Nodeca project)",sr={deflateInit:iS,deflateInit2:rS,deflateReset:sS,deflateResetKeep:aS,deflateSetHeader:oS,deflate:lS,deflateEnd:cS,deflateSetDictionary:hS,deflateInfo:uS},fS=(n,t)=>Object.prototype.hasOwnProperty.call(n,t),dS=function(n){let t=Array.prototype.slice.call(arguments,1);for(;t.length;){let e=t.shift();if(e){if(typeof e!="object")throw new TypeError(e+"must be non-object");for(let i in e)fS(e,i)&&(n[i]=e[i])}}return n},pS=n=>{let t=0;for(let i=0,r=n.length;i<r;i++)t+=n[i].length;let e=new Uint8Array(t);for(let i=0,r=0,s=n.length;i<s;i++){let a=n[i];e.set(a,r),r+=a.length}return e},Bs={assign:dS,flattenChunks:pS},ju=!0;try{String.fromCharCode.apply(null,new Uint8Array(1))}catch{ju=!1}var fr=new Uint8Array(256);for(let n=0;n<256;n++)fr[n]=n>=252?6:n>=248?5:n>=240?4:n>=224?3:n>=192?2:1;fr[254]=fr[255]=1;var mS=n=>{if(typeof TextEncoder=="function"&&TextEncoder.prototype.encode)return new TextEncoder().encode(n);let t,e,i,r,s,a=n.length,o=0;for(r=0;r<a;r++)e=n.charCodeAt(r),(e&64512)===55296&&r+1<a&&(i=n.charCodeAt(r+1),(i&64512)===56320&&(e=65536+(e-55296<<10)+(i-56320),r++)),o+=e<128?1:e<2048?2:e<65536?3:4;for(t=new Uint8Array(o),s=0,r=0;s<o;r++)e=n.charCodeAt(r),(e&64512)===55296&&r+1<a&&(i=n.charCodeAt(r+1),(i&64512)===56320&&(e=65536+(e-55296<<10)+(i-56320),r++)),e<128?t[s++]=e:e<2048?(t[s++]=192|e>>>6,t[s++]=128|e&63):e<65536?(t[s++]=224|e>>>12,t[s++]=128|e>>>6&63,t[s++]=128|e&63):(t[s++]=240|e>>>18,t[s++]=128|e>>>12&63,t[s++]=128|e>>>6&63,t[s++]=128|e&63);return t},gS=(n,t)=>{if(t<65534&&n.subarray&&ju)return String.fromCharCode.apply(null,n.length===t?n:n.subarray(0,t));let e="";for(let i=0;i<t;i++)e+=String.fromCharCode(n[i]);return e},_S=(n,t)=>{let e=t||n.length;if(typeof TextDecoder=="function"&&TextDecoder.prototype.decode)return new TextDecoder().decode(n.subarray(0,t));let i,r,s=new Array(e*2);for(r=0,i=0;i<e;){let a=n[i++];if(a<128){s[r++]=a;continue}let o=fr[a];if(o>4){s[r++]=65533,i+=o-1;continue}for(a&=o===2?31:o===3?15:7;o>1&&i<e;)a=a<<6|n[i++]&63,o--;if(o>1){s[r++]=65533;continue}a<65536?s[r++]=a:(a-=65536,s[r++]=55296|a>>10&1023,s[r++]=56320|a&1023)}return gS(s,r)},xS=(n,t)=>{t=t||n.length,t>n.length&&(t=n.length);let e=t-1;for(;e>=0&&(n[e]&192)===128;)e--;return e<0||e===0?t:e+fr[n[e]]>t?e:t},dr={string2buf:mS,buf2string:_S,utf8border:xS};function vS(){this.input=null,this.next_in=0,this.avail_in=0,this.total_in=0,this.output=null,this.next_out=0,this.avail_out=0,this.total_out=0,this.msg="",this.state=null,this.data_type=2,this.adler=0}var tf=vS,ef=Object.prototype.toString,{Z_NO_FLUSH:yS,Z_SYNC_FLUSH:SS,Z_FULL_FLUSH:MS,Z_FINISH:bS,Z_OK:Us,Z_STREAM_END:wS,Z_DEFAULT_COMPRESSION:ES,Z_DEFAULT_STRATEGY:AS,Z_DEFLATED:TS}=Dn,RS={level:ES,method:TS,chunkSize:16384,windowBits:15,memLevel:8,strategy:AS,legacyHash:!0};function gr(n){this.options=Bs.assign({},RS,n||{});let t=this.options;t.raw&&t.windowBits>0?t.windowBits=-t.windowBits:t.gzip&&t.windowBits>0&&t.windowBits<16&&(t.windowBits+=16),this.err=0,this.msg="",this.ended=!1,this.chunks=[],this.strm=new tf,this.strm.avail_out=0;let e=sr.deflateInit2(this.strm,t.level,t.method,t.windowBits,t.memLevel,t.strategy,t.legacyHash);if(e!==Us)throw new Error(In[e]);if(t.header&&sr.deflateSetHeader(this.strm,t.header),t.dictionary){let i;if(typeof t.dictionary=="string"?i=dr.string2buf(t.dictionary):ef.call(t.dictionary)==="[object ArrayBuffer]"?i=new Uint8Array(t.dictionary):i=t.dictionary,e=sr.deflateSetDictionary(this.strm,i),e!==Us)throw new Error(In[e]);this._dict_set=!0}}gr.prototype.push=function(n,t){let e=this.strm,i=this.options.chunkSize,r,s;if(this.ended)return!1;for(t===~~t?s=t:s=t===!0?bS:yS,typeof n=="string"?e.input=dr.string2buf(n):ef.call(n)==="[object ArrayBuffer]"?e.input=new Uint8Array(n):e.input=n,e.next_in=0,e.avail_in=e.input.length;;){if(e.avail_out===0&&(e.output=new Uint8Array(i),e.next_out=0,e.avail_out=i),(s===SS||s===MS)&&e.avail_out<=6){this.onData(e.output.subarray(0,e.next_out)),e.avail_out=0;continue}if(r=sr.deflate(e,s),r===wS)return e.next_out>0&&this.onData(e.output.subarray(0,e.next_out)),r=sr.deflateEnd(this.strm),this.onEnd(r),this.ended=!0,r===Us;if(e.avail_out===0){this.onData(e.output);continue}if(s>0&&e.next_out>0){this.onData(e.output.subarray(0,e.next_out)),e.avail_out=0;continue}if(e.avail_in===0)break}return!0};gr.prototype.onData=function(n){this.chunks.push(n)};gr.prototype.onEnd=function(n){n===Us&&(this.result=Bs.flattenChunks(this.chunks)),this.chunks=[],this.err=n,this.msg=this.strm.msg};function yl(n,t){let e=new gr(t);if(e.push(n,!0),e.err)throw e.msg||In[e.err];return e.result}function CS(n,t){return t=t||{},t.raw=!0,yl(n,t)}function IS(n,t){return t=t||{},t.gzip=!0,yl(n,t)}var PS=gr,NS=yl,LS=CS,DS=IS,US=Dn,FS={Deflate:PS,deflate:NS,deflateRaw:LS,gzip:DS,constants:US},Cs=16209,OS=16191,BS=function(t,e){let i,r,s,a,o,h,l,c,u,d,f,p,m,g,_,y,v,x,w,b,A,I,C,P,L=t.state;i=t.next_in,C=t.input,r=i+(t.avail_in-5),s=t.next_out,P=t.output,a=s-(e-t.avail_out),o=s+(t.avail_out-257),h=L.dmax,l=L.wsize,c=L.whave,u=L.wnext,d=L.window,f=L.hold,p=L.bits,m=L.lencode,g=L.distcode,_=(1<<L.lenbits)-1,y=(1<<L.distbits)-1;t:do{p<15&&(f+=C[i++]<<p,p+=8,f+=C[i++]<<p,p+=8),v=m[f&_];e:for(;;){if(x=v>>>24,f>>>=x,p-=x,x=v>>>16&255,x===0)P[s++]=v&65535;else if(x&16){w=v&65535,x&=15,x&&(p<x&&(f+=C[i++]<<p,p+=8),w+=f&(1<<x)-1,f>>>=x,p-=x),p<15&&(f+=C[i++]<<p,p+=8,f+=C[i++]<<p,p+=8),v=g[f&y];n:for(;;){if(x=v>>>24,f>>>=x,p-=x,x=v>>>16&255,x&16){if(b=v&65535,x&=15,p<x&&(f+=C[i++]<<p,p+=8,p<x&&(f+=C[i++]<<p,p+=8)),b+=f&(1<<x)-1,b>h){t.msg="invalid distance too far back",L.mode=Cs;break t}if(f>>>=x,p-=x,x=s-a,b>x){if(x=b-x,x>c&&L.sane){t.msg="invalid distance too far back",L.mode=Cs;break t}if(A=0,I=d,u===0){if(A+=l-x,x<w){w-=x;do P[s++]=d[A++];while(--x);A=s-b,I=P}}else if(u<x){if(A+=l+u-x,x-=u,x<w){w-=x;do P[s++]=d[A++];while(--x);if(A=0,u<w){x=u,w-=x;do P[s++]=d[A++];while(--x);A=s-b,I=P}}}else if(A+=u-x,x<w){w-=x;do P[s++]=d[A++];while(--x);A=s-b,I=P}for(;w>2;)P[s++]=I[A++],P[s++]=I[A++],P[s++]=I[A++],w-=3;w&&(P[s++]=I[A++],w>1&&(P[s++]=I[A++]))}else{A=s-b;do P[s++]=P[A++],P[s++]=P[A++],P[s++]=P[A++],w-=3;while(w>2);w&&(P[s++]=P[A++],w>1&&(P[s++]=P[A++]))}}else if((x&64)===0){v=g[(v&65535)+(f&(1<<x)-1)];continue n}else{t.msg="invalid distance code",L.mode=Cs;break t}break}}else if((x&64)===0){v=m[(v&65535)+(f&(1<<x)-1)];continue e}else if(x&32){L.mode=OS;break t}else{t.msg="invalid literal/length code",L.mode=Cs;break t}break}}while(i<r&&s<o);w=p>>3,i-=w,p-=w<<3,f&=(1<<p)-1,t.next_in=i,t.next_out=s,t.avail_in=i<r?5+(r-i):5-(i-r),t.avail_out=s<o?257+(o-s):257-(s-o),L.hold=f,L.bits=p},gi=15,eu=852,nu=592,iu=0,Ko=1,ru=2,zS=new Uint16Array([3,4,5,6,7,8,9,10,11,13,15,17,19,23,27,31,35,43,51,59,67,83,99,115,131,163,195,227,258,0,0]),kS=new Uint8Array([16,16,16,16,16,16,16,16,17,17,17,17,18,18,18,18,19,19,19,19,20,20,20,20,21,21,21,21,16,199,75]),GS=new Uint16Array([1,2,3,4,5,7,9,13,17,25,33,49,65,97,129,193,257,385,513,769,1025,1537,2049,3073,4097,6145,8193,12289,16385,24577,0,0]),VS=new Uint8Array([16,16,16,16,17,17,18,18,19,19,20,20,21,21,22,22,23,23,24,24,25,25,26,26,27,27,28,28,29,29,64,64]),HS=(n,t,e,i,r,s,a,o)=>{let h=o.bits,l=0,c=0,u=0,d=0,f=0,p=0,m=0,g=0,_=0,y=0,v,x,w,b,A,I=null,C,P=new Uint16Array(gi+1),L=new Uint16Array(gi+1),G=null,q,V,B;for(l=0;l<=gi;l++)P[l]=0;for(c=0;c<i;c++)P[t[e+c]]++;for(f=h,d=gi;d>=1&&P[d]===0;d--);if(f>d&&(f=d),d===0)return r[s++]=1<<24|64<<16|0,r[s++]=1<<24|64<<16|0,o.bits=1,0;for(u=1;u<d&&P[u]===0;u++);for(f<u&&(f=u),g=1,l=1;l<=gi;l++)if(g<<=1,g-=P[l],g<0)return-1;if(g>0&&(n===iu||d!==1))return-1;for(L[1]=0,l=1;l<gi;l++)L[l+1]=L[l]+P[l];for(c=0;c<i;c++)t[e+c]!==0&&(a[L[t[e+c]]++]=c);if(n===iu?(I=G=a,C=20):n===Ko?(I=zS,G=kS,C=257):(I=GS,G=VS,C=0),y=0,c=0,l=u,A=s,p=f,m=0,w=-1,_=1<<f,b=_-1,n===Ko&&_>eu||n===ru&&_>nu)return 1;for(;;){q=l-m,a[c]+1<C?(V=0,B=a[c]):a[c]>=C?(V=G[a[c]-C],B=I[a[c]-C]):(V=96,B=0),v=1<<l-m,x=1<<p,u=x;do x-=v,r[A+(y>>m)+x]=q<<24|V<<16|B|0;while(x!==0);for(v=1<<l-1;y&v;)v>>=1;if(v!==0?(y&=v-1,y+=v):y=0,c++,--P[l]===0){if(l===d)break;l=t[e+a[c]]}if(l>f&&(y&b)!==w){for(m===0&&(m=f),A+=u,p=l-m,g=1<<p;p+m<d&&(g-=P[p+m],!(g<=0));)p++,g<<=1;if(_+=1<<p,n===Ko&&_>eu||n===ru&&_>nu)return 1;w=y&b,r[w]=f<<24|p<<16|A-s|0}}return y!==0&&(r[A+y]=l-m<<24|64<<16|0),o.bits=f,0},ar=HS,WS=0,nf=1,rf=2,{Z_FINISH:su,Z_BLOCK:XS,Z_TREES:Is,Z_OK:Ln,Z_STREAM_END:qS,Z_NEED_DICT:YS,Z_STREAM_ERROR:Se,Z_DATA_ERROR:sf,Z_MEM_ERROR:af,Z_BUF_ERROR:ZS,Z_DEFLATED:au}=Dn,zs=16180,ou=16181,lu=16182,cu=16183,hu=16184,uu=16185,fu=16186,du=16187,pu=16188,mu=16189,Fs=16190,Ke=16191,Qo=16192,gu=16193,jo=16194,_u=16195,xu=16196,vu=16197,yu=16198,Ps=16199,Ns=16200,Su=16201,Mu=16202,bu=16203,wu=16204,Eu=16205,tl=16206,Au=16207,Tu=16208,bt=16209,of=16210,lf=16211,JS=852,$S=592,KS=15,QS=KS,Ru=n=>(n>>>24&255)+(n>>>8&65280)+((n&65280)<<8)+((n&255)<<24);function jS(){this.strm=null,this.mode=0,this.last=!1,this.wrap=0,this.havedict=!1,this.flags=0,this.dmax=0,this.check=0,this.total=0,this.head=null,this.wbits=0,this.wsize=0,this.whave=0,this.wnext=0,this.window=null,this.hold=0,this.bits=0,this.length=0,this.offset=0,this.extra=0,this.lencode=null,this.distcode=null,this.lenbits=0,this.distbits=0,this.ncode=0,this.nlen=0,this.ndist=0,this.have=0,this.next=null,this.lens=new Uint16Array(320),this.work=new Uint16Array(288),this.lendyn=null,this.distdyn=null,this.sane=0,this.back=0,this.was=0}var Un=n=>{if(!n)return 1;let t=n.state;return!t||t.strm!==n||t.mode<zs||t.mode>lf?1:0},cf=n=>{if(Un(n))return Se;let t=n.state;return n.total_in=n.total_out=t.total=0,n.msg="",t.wrap&&(n.adler=t.wrap&1),t.mode=zs,t.last=0,t.havedict=0,t.flags=-1,t.dmax=32768,t.head=null,t.hold=0,t.bits=0,t.lencode=t.lendyn=new Int32Array(JS),t.distcode=t.distdyn=new Int32Array($S),t.sane=1,t.back=-1,Ln},hf=n=>{if(Un(n))return Se;let t=n.state;return t.wsize=0,t.whave=0,t.wnext=0,cf(n)},uf=(n,t)=>{let e;if(Un(n))return Se;let i=n.state;return t<0?(e=0,t=-t):(e=(t>>4)+5,t<48&&(t&=15)),t&&(t<8||t>15)?Se:(i.window!==null&&i.wbits!==t&&(i.window=null),i.wrap=e,i.wbits=t,hf(n))},ff=(n,t)=>{if(!n)return Se;let e=new jS;n.state=e,e.strm=n,e.window=null,e.mode=zs;let i=uf(n,t);return i!==Ln&&(n.state=null),i},tM=n=>ff(n,QS),Cu=!0,el,nl,eM=n=>{if(Cu){el=new Int32Array(512),nl=new Int32Array(32);let t=0;for(;t<144;)n.lens[t++]=8;for(;t<256;)n.lens[t++]=9;for(;t<280;)n.lens[t++]=7;for(;t<288;)n.lens[t++]=8;for(ar(nf,n.lens,0,288,el,0,n.work,{bits:9}),t=0;t<32;)n.lens[t++]=5;ar(rf,n.lens,0,32,nl,0,n.work,{bits:5}),Cu=!1}n.lencode=el,n.lenbits=9,n.distcode=nl,n.distbits=5},df=(n,t,e,i)=>{let r,s=n.state;return s.window===null&&(s.window=new Uint8Array(1<<s.wbits)),s.wsize===0&&(s.wsize=1<<s.wbits,s.wnext=0,s.whave=0),i>=s.wsize?(s.window.set(t.subarray(e-s.wsize,e),0),s.wnext=0,s.whave=s.wsize):(r=s.wsize-s.wnext,r>i&&(r=i),s.window.set(t.subarray(e-i,e-i+r),s.wnext),i-=r,i?(s.window.set(t.subarray(e-i,e),0),s.wnext=i,s.whave=s.wsize):(s.wnext+=r,s.wnext===s.wsize&&(s.wnext=0),s.whave<s.wsize&&(s.whave+=r))),0},nM=(n,t)=>{let e,i,r,s,a,o,h,l,c,u,d,f,p,m,g=0,_,y,v,x,w,b,A,I,C=new Uint8Array(4),P,L,G=new Uint8Array([16,17,18,0,8,7,9,6,10,5,11,4,12,3,13,2,14,1,15]);if(Un(n)||!n.output||!n.input&&n.avail_in!==0)return Se;e=n.state,e.mode===Ke&&(e.mode=Qo),a=n.next_out,r=n.output,h=n.avail_out,s=n.next_in,i=n.input,o=n.avail_in,l=e.hold,c=e.bits,u=o,d=h,I=Ln;t:for(;;)switch(e.mode){case zs:if(e.wrap===0){e.mode=Qo;break}for(;c<16;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(e.wrap&2&&l===35615){e.wbits===0&&(e.wbits=15),e.check=0,C[0]=l&255,C[1]=l>>>8&255,e.check=kt(e.check,C,2,0),l=0,c=0,e.mode=ou;break}if(e.head&&(e.head.done=!1),!(e.wrap&1)||(((l&255)<<8)+(l>>8))%31){n.msg="incorrect header check",e.mode=bt;break}if((l&15)!==au){n.msg="unknown compression method",e.mode=bt;break}if(l>>>=4,c-=4,A=(l&15)+8,e.wbits===0&&(e.wbits=A),A>15||A>e.wbits){n.msg="invalid window size",e.mode=bt;break}e.dmax=1<<e.wbits,e.flags=0,n.adler=e.check=1,e.mode=l&512?mu:Ke,l=0,c=0;break;case ou:for(;c<16;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(e.flags=l,(e.flags&255)!==au){n.msg="unknown compression method",e.mode=bt;break}if(e.flags&57344){n.msg="unknown header flags set",e.mode=bt;break}e.head&&(e.head.text=l>>8&1),e.flags&512&&e.wrap&4&&(C[0]=l&255,C[1]=l>>>8&255,e.check=kt(e.check,C,2,0)),l=0,c=0,e.mode=lu;case lu:for(;c<32;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}e.head&&(e.head.time=l),e.flags&512&&e.wrap&4&&(C[0]=l&255,C[1]=l>>>8&255,C[2]=l>>>16&255,C[3]=l>>>24&255,e.check=kt(e.check,C,4,0)),l=0,c=0,e.mode=cu;case cu:for(;c<16;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}e.head&&(e.head.xflags=l&255,e.head.os=l>>8),e.flags&512&&e.wrap&4&&(C[0]=l&255,C[1]=l>>>8&255,e.check=kt(e.check,C,2,0)),l=0,c=0,e.mode=hu;case hu:if(e.flags&1024){for(;c<16;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}e.length=l,e.head&&(e.head.extra_len=l),e.flags&512&&e.wrap&4&&(C[0]=l&255,C[1]=l>>>8&255,e.check=kt(e.check,C,2,0)),l=0,c=0}else e.head&&(e.head.extra=null);e.mode=uu;case uu:if(e.flags&1024&&(f=e.length,f>o&&(f=o),f&&(e.head&&(A=e.head.extra_len-e.length,e.head.extra||(e.head.extra=new Uint8Array(e.head.extra_len)),e.head.extra.set(i.subarray(s,s+f),A)),e.flags&512&&e.wrap&4&&(e.check=kt(e.check,i,f,s)),o-=f,s+=f,e.length-=f),e.length))break t;e.length=0,e.mode=fu;case fu:if(e.flags&2048){if(o===0)break t;f=0;do A=i[s+f++],e.head&&A&&e.length<65536&&(e.head.name+=String.fromCharCode(A));while(A&&f<o);if(e.flags&512&&e.wrap&4&&(e.check=kt(e.check,i,f,s)),o-=f,s+=f,A)break t}else e.head&&(e.head.name=null);e.length=0,e.mode=du;case du:if(e.flags&4096){if(o===0)break t;f=0;do A=i[s+f++],e.head&&A&&e.length<65536&&(e.head.comment+=String.fromCharCode(A));while(A&&f<o);if(e.flags&512&&e.wrap&4&&(e.check=kt(e.check,i,f,s)),o-=f,s+=f,A)break t}else e.head&&(e.head.comment=null);e.mode=pu;case pu:if(e.flags&512){for(;c<16;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(e.wrap&4&&l!==(e.check&65535)){n.msg="header crc mismatch",e.mode=bt;break}l=0,c=0}e.head&&(e.head.hcrc=e.flags>>9&1,e.head.done=!0),n.adler=e.check=0,e.mode=Ke;break;case mu:for(;c<32;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}n.adler=e.check=Ru(l),l=0,c=0,e.mode=Fs;case Fs:if(e.havedict===0)return n.next_out=a,n.avail_out=h,n.next_in=s,n.avail_in=o,e.hold=l,e.bits=c,YS;n.adler=e.check=1,e.mode=Ke;case Ke:if(t===XS||t===Is)break t;case Qo:if(e.last){l>>>=c&7,c-=c&7,e.mode=tl;break}for(;c<3;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}switch(e.last=l&1,l>>>=1,c-=1,l&3){case 0:e.mode=gu;break;case 1:if(eM(e),e.mode=Ps,t===Is){l>>>=2,c-=2;break t}break;case 2:e.mode=xu;break;case 3:n.msg="invalid block type",e.mode=bt}l>>>=2,c-=2;break;case gu:for(l>>>=c&7,c-=c&7;c<32;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if((l&65535)!==(l>>>16^65535)){n.msg="invalid stored block lengths",e.mode=bt;break}if(e.length=l&65535,l=0,c=0,e.mode=jo,t===Is)break t;case jo:e.mode=_u;case _u:if(f=e.length,f){if(f>o&&(f=o),f>h&&(f=h),f===0)break t;r.set(i.subarray(s,s+f),a),o-=f,s+=f,h-=f,a+=f,e.length-=f;break}e.mode=Ke;break;case xu:for(;c<14;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(e.nlen=(l&31)+257,l>>>=5,c-=5,e.ndist=(l&31)+1,l>>>=5,c-=5,e.ncode=(l&15)+4,l>>>=4,c-=4,e.nlen>286||e.ndist>30){n.msg="too many length or distance symbols",e.mode=bt;break}e.have=0,e.mode=vu;case vu:for(;e.have<e.ncode;){for(;c<3;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}e.lens[G[e.have++]]=l&7,l>>>=3,c-=3}for(;e.have<19;)e.lens[G[e.have++]]=0;if(e.lencode=e.lendyn,e.lenbits=7,P={bits:e.lenbits},I=ar(WS,e.lens,0,19,e.lencode,0,e.work,P),e.lenbits=P.bits,I){n.msg="invalid code lengths set",e.mode=bt;break}e.have=0,e.mode=yu;case yu:for(;e.have<e.nlen+e.ndist;){for(;g=e.lencode[l&(1<<e.lenbits)-1],_=g>>>24,y=g>>>16&255,v=g&65535,!(_<=c);){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(v<16)l>>>=_,c-=_,e.lens[e.have++]=v;else{if(v===16){for(L=_+2;c<L;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(l>>>=_,c-=_,e.have===0){n.msg="invalid bit length repeat",e.mode=bt;break}A=e.lens[e.have-1],f=3+(l&3),l>>>=2,c-=2}else if(v===17){for(L=_+3;c<L;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}l>>>=_,c-=_,A=0,f=3+(l&7),l>>>=3,c-=3}else{for(L=_+7;c<L;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}l>>>=_,c-=_,A=0,f=11+(l&127),l>>>=7,c-=7}if(e.have+f>e.nlen+e.ndist){n.msg="invalid bit length repeat",e.mode=bt;break}for(;f--;)e.lens[e.have++]=A}}if(e.mode===bt)break;if(e.lens[256]===0){n.msg="invalid code -- missing end-of-block",e.mode=bt;break}if(e.lenbits=9,P={bits:e.lenbits},I=ar(nf,e.lens,0,e.nlen,e.lencode,0,e.work,P),e.lenbits=P.bits,I){n.msg="invalid literal/lengths set",e.mode=bt;break}if(e.distbits=6,e.distcode=e.distdyn,P={bits:e.distbits},I=ar(rf,e.lens,e.nlen,e.ndist,e.distcode,0,e.work,P),e.distbits=P.bits,I){n.msg="invalid distances set",e.mode=bt;break}if(e.mode=Ps,t===Is)break t;case Ps:e.mode=Ns;case Ns:if(o>=6&&h>=258){n.next_out=a,n.avail_out=h,n.next_in=s,n.avail_in=o,e.hold=l,e.bits=c,BS(n,d),a=n.next_out,r=n.output,h=n.avail_out,s=n.next_in,i=n.input,o=n.avail_in,l=e.hold,c=e.bits,e.mode===Ke&&(e.back=-1);break}for(e.back=0;g=e.lencode[l&(1<<e.lenbits)-1],_=g>>>24,y=g>>>16&255,v=g&65535,!(_<=c);){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(y&&(y&240)===0){for(x=_,w=y,b=v;g=e.lencode[b+((l&(1<<x+w)-1)>>x)],_=g>>>24,y=g>>>16&255,v=g&65535,!(x+_<=c);){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}l>>>=x,c-=x,e.back+=x}if(l>>>=_,c-=_,e.back+=_,e.length=v,y===0){e.mode=Eu;break}if(y&32){e.back=-1,e.mode=Ke;break}if(y&64){n.msg="invalid literal/length code",e.mode=bt;break}e.extra=y&15,e.mode=Su;case Su:if(e.extra){for(L=e.extra;c<L;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}e.length+=l&(1<<e.extra)-1,l>>>=e.extra,c-=e.extra,e.back+=e.extra}e.was=e.length,e.mode=Mu;case Mu:for(;g=e.distcode[l&(1<<e.distbits)-1],_=g>>>24,y=g>>>16&255,v=g&65535,!(_<=c);){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if((y&240)===0){for(x=_,w=y,b=v;g=e.distcode[b+((l&(1<<x+w)-1)>>x)],_=g>>>24,y=g>>>16&255,v=g&65535,!(x+_<=c);){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}l>>>=x,c-=x,e.back+=x}if(l>>>=_,c-=_,e.back+=_,y&64){n.msg="invalid distance code",e.mode=bt;break}e.offset=v,e.extra=y&15,e.mode=bu;case bu:if(e.extra){for(L=e.extra;c<L;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}e.offset+=l&(1<<e.extra)-1,l>>>=e.extra,c-=e.extra,e.back+=e.extra}if(e.offset>e.dmax){n.msg="invalid distance too far back",e.mode=bt;break}e.mode=wu;case wu:if(h===0)break t;if(f=d-h,e.offset>f){if(f=e.offset-f,f>e.whave&&e.sane){n.msg="invalid distance too far back",e.mode=bt;break}f>e.wnext?(f-=e.wnext,p=e.wsize-f):p=e.wnext-f,f>e.length&&(f=e.length),m=e.window}else m=r,p=a-e.offset,f=e.length;f>h&&(f=h),h-=f,e.length-=f;do r[a++]=m[p++];while(--f);e.length===0&&(e.mode=Ns);break;case Eu:if(h===0)break t;r[a++]=e.length,h--,e.mode=Ns;break;case tl:if(e.wrap){for(;c<32;){if(o===0)break t;o--,l|=i[s++]<<c,c+=8}if(d-=h,n.total_out+=d,e.total+=d,e.wrap&4&&d&&(n.adler=e.check=e.flags?kt(e.check,r,d,a-d):ur(e.check,r,d,a-d)),d=h,e.wrap&4&&(e.flags?l:Ru(l))!==e.check){n.msg="incorrect data check",e.mode=bt;break}l=0,c=0}e.mode=Au;case Au:if(e.wrap&&e.flags){for(;c<32;){if(o===0)break t;o--,l+=i[s++]<<c,c+=8}if(e.wrap&4&&l!==(e.total&4294967295)){n.msg="incorrect length check",e.mode=bt;break}l=0,c=0}e.mode=Tu;case Tu:I=qS;break t;case bt:I=sf;break t;case of:return af;case lf:default:return Se}return n.next_out=a,n.avail_out=h,n.next_in=s,n.avail_in=o,e.hold=l,e.bits=c,(e.wsize||d!==n.avail_out&&e.mode<bt&&(e.mode<tl||t!==su))&&df(n,n.output,n.next_out,d-n.avail_out),u-=n.avail_in,d-=n.avail_out,n.total_in+=u,n.total_out+=d,e.total+=d,e.wrap&4&&d&&(n.adler=e.check=e.flags?kt(e.check,r,d,n.next_out-d):ur(e.check,r,d,n.next_out-d)),n.data_type=e.bits+(e.last?64:0)+(e.mode===Ke?128:0)+(e.mode===Ps||e.mode===jo?256:0),(u===0&&d===0||t===su)&&I===Ln&&(I=ZS),I},iM=n=>{if(Un(n))return Se;let t=n.state;return t.window&&(t.window=null),n.state=null,Ln},rM=(n,t)=>{if(Un(n))return Se;let e=n.state;return(e.wrap&2)===0?Se:(e.head=t,t.done=!1,Ln)},sM=(n,t)=>{let e=t.length,i,r,s;return Un(n)||(i=n.state,i.wrap!==0&&i.mode!==Fs)?Se:i.mode===Fs&&(r=1,r=ur(r,t,e,0),r!==i.check)?sf:(s=df(n,t,e,e),s?(i.mode=of,af):(i.havedict=1,Ln))},aM=hf,oM=uf,lM=cf,cM=tM,hM=ff,uM=nM,fM=iM,dM=rM,pM=sM,mM="pako inflate (from Nodeca project)",Oe={inflateReset:aM,inflateReset2:oM,inflateResetKeep:lM,inflateInit:cM,inflateInit2:hM,inflate:uM,inflateEnd:fM,inflateGetHeader:dM,inflateSetDictionary:pM,inflateInfo:mM};function gM(){this.text=0,this.time=0,this.xflags=0,this.os=0,this.extra=null,this.extra_len=0,this.name="",this.comment="",this.hcrc=0,this.done=!1}var _M=gM,pf=Object.prototype.toString,{Z_NO_FLUSH:xM,Z_FINISH:Iu,Z_OK:xi,Z_STREAM_END:il,Z_NEED_DICT:rl,Z_STREAM_ERROR:vM,Z_DATA_ERROR:Pu,Z_MEM_ERROR:yM,Z_BUF_ERROR:Nu}=Dn,SM={chunkSize:1024*64,windowBits:15,to:""};function _r(n){this.options=Bs.assign({},SM,n||{});let t=this.options;t.raw&&t.windowBits>=0&&t.windowBits<16&&(t.windowBits=-t.windowBits,t.windowBits===0&&(t.windowBits=-15)),t.windowBits>=0&&t.windowBits<16&&!(n&&n.windowBits)&&(t.windowBits+=32),t.windowBits>15&&t.windowBits<48&&(t.windowBits&15)===0&&(t.windowBits|=15),this.err=0,this.msg="",this.ended=!1,this.chunks=[],this.strm=new tf,this.strm.avail_out=0;let e=Oe.inflateInit2(this.strm,t.windowBits);if(e!==xi)throw new Error(In[e]);if(this.header=new _M,Oe.inflateGetHeader(this.strm,this.header),t.dictionary&&(typeof t.dictionary=="string"?t.dictionary=dr.string2buf(t.dictionary):pf.call(t.dictionary)==="[object ArrayBuffer]"&&(t.dictionary=new Uint8Array(t.dictionary)),t.raw&&(e=Oe.inflateSetDictionary(this.strm,t.dictionary),e!==xi)))throw new Error(In[e])}_r.prototype.push=function(n,t){let e=this.strm,i=this.options.chunkSize,r=this.options.dictionary,s,a,o;if(this.ended)return!1;for(t===~~t?a=t:a=t===!0?Iu:xM,pf.call(n)==="[object ArrayBuffer]"?e.input=new Uint8Array(n):e.input=n,e.next_in=0,e.avail_in=e.input.length;;){for(e.avail_out===0&&(e.output=new Uint8Array(i),e.next_out=0,e.avail_out=i),s=Oe.inflate(e,a),s===rl&&r&&(s=Oe.inflateSetDictionary(e,r),s===xi?s=Oe.inflate(e,a):s===Pu&&(s=rl));e.avail_in>0&&s===il&&e.state.wrap&2&&e.state.flags!==0&&e.input[e.next_in]!==0;)Oe.inflateReset(e),s=Oe.inflate(e,a);switch(s){case vM:case Pu:case rl:case yM:return this.onEnd(s),this.ended=!0,!1}if(o=e.avail_out,e.next_out&&(e.avail_out===0||s===il||a>0))if(this.options.to==="string"){let h=dr.utf8border(e.output,e.next_out),l=e.next_out-h,c=dr.buf2string(e.output,h);e.next_out=l,e.avail_out=i-l,l&&e.output.set(e.output.subarray(h,h+l),0),this.onData(c)}else this.onData(e.output.length===e.next_out?e.output:e.output.subarray(0,e.next_out)),e.avail_out=0,e.next_out=0;if(!((s===xi||s===Nu)&&o===0)){if(s===il)return s=Oe.inflateEnd(this.strm),this.onEnd(s),this.ended=!0,!0;if(e.avail_in===0){if(a===Iu)return s=Oe.inflateEnd(this.strm),this.onEnd(s===xi?Nu:s),this.ended=!0,!1;break}}}return!0};_r.prototype.onData=function(n){this.chunks.push(n)};_r.prototype.onEnd=function(n){n===xi&&(this.options.to==="string"?this.result=this.chunks.join(""):this.result=Bs.flattenChunks(this.chunks)),this.chunks=[],this.err=n,this.msg=this.strm.msg};function Sl(n,t){let e=new _r(t);if(e.push(n,!0),e.err)throw e.msg||In[e.err];return e.result}function MM(n,t){return t=t||{},t.raw=!0,Sl(n,t)}var bM=_r,wM=Sl,EM=MM,AM=Sl,TM=Dn,RM={Inflate:bM,inflate:wM,inflateRaw:EM,ungzip:AM,constants:TM},{Deflate:CM,deflate:IM,deflateRaw:PM,gzip:NM}=FS,{Inflate:LM,inflate:DM,inflateRaw:UM,ungzip:FM}=RM,OM=CM,BM=IM,zM=PM,kM=NM,GM=LM,VM=DM,HM=UM,WM=FM,XM=Dn,ks={Deflate:OM,deflate:BM,deflateRaw:zM,gzip:kM,Inflate:GM,inflate:VM,inflateRaw:HM,ungzip:WM,constants:XM};var U;(function(n){n[n.End=0]="End",n[n.Byte=1]="Byte",n[n.Short=2]="Short",n[n.Int=3]="Int",n[n.Long=4]="Long",n[n.Float=5]="Float",n[n.Double=6]="Double",n[n.ByteArray=7]="ByteArray",n[n.String=8]="String",n[n.List=9]="List",n[n.Compound=10]="Compound",n[n.IntArray=11]="IntArray",n[n.LongArray=12]="LongArray"})(U=U||(U={}));var J=class n{static FACTORIES=new Map;static register(t,e){let i=e.create().getId();if(i!==t)throw new Error(`Registered factory ${U[i]} does not match type ${U[t]}`);n.FACTORIES.set(t,e)}isEnd(){return this.getId()===U.End}isByte(){return this.getId()===U.Byte}isShort(){return this.getId()===U.Short}isInt(){return this.getId()===U.Int}isLong(){return this.getId()===U.Long}isFloat(){return this.getId()===U.Float}isDouble(){return this.getId()===U.Double}isByteArray(){return this.getId()===U.ByteArray}isString(){return this.getId()===U.String}isList(){return this.getId()===U.List}isCompound(){return this.getId()===U.Compound}isIntArray(){return this.getId()===U.IntArray}isLongArray(){return this.getId()===U.LongArray}isNumber(){return this.isByte()||this.isShort()||this.isInt()||this.isLong()||this.isFloat()||this.isDouble()}isArray(){return this.isByteArray()||this.isIntArray()||this.isLongArray()}isListOrArray(){return this.isList()||this.isArray()}getAsNumber(){return 0}getAsString(){return""}toJsonWithId(){return{type:this.getId(),value:this.toJson()}}static getFactory(t){let e=this.FACTORIES.get(t);if(!e)throw new Error(`Invalid tag id ${t}`);return e}static create(t){return this.getFactory(t).create()}static fromString(t){let e=typeof t=="string"?new xe(t):t;return this.getFactory(U.Compound).fromString(e)}static fromJson(t,e=U.Compound){return this.getFactory(e).fromJson(t)}static fromJsonWithId(t){let e=M.readObject(t)??{},i=M.readInt(e.type)??0;return n.fromJson(e.value??{},i)}static fromBytes(t,e=U.Compound){return this.getFactory(e).fromBytes(t)}};var Ge=class n extends J{static ZERO=new n(0);static ONE=new n(1);value;constructor(t){super(),this.value=typeof t=="number"?t:t?1:0}getId(){return U.Byte}equals(t){return t.isByte()&&this.value===t.value}getAsNumber(){return this.value}toString(){return this.value.toFixed()+"b"}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.value}toJson(){return this.value}toBytes(t){t.writeByte(this.value)}static create(){return n.ZERO}static fromJson(t){return new n(M.readInt(t)??0)}static fromBytes(t){let e=t.readByte();return new n(e)}};J.register(U.Byte,Ge);var Ve=class extends J{items;constructor(t){super(),this.items=t}getItems(){return this.items.slice(0)}getAsTuple(t,e){return[...Array(t)].map((i,r)=>e(this.items[r]))}get(t){if(t=Math.floor(t),!(t<0||t>=this.items.length))return this.items[t]}get length(){return this.items.length}map(t){return this.items.map(t)}filter(t){return this.items.filter(t)}forEach(t){this.items.forEach(t)}set(t,e){this.items[t]=e}add(t){this.items.push(t)}insert(t,e){this.items.splice(t,0,e)}delete(t){this.items.splice(t,1)}clear(){this.items=[]}};var Fn=class n extends Ve{constructor(t){super(Array.from(t??[],e=>typeof e=="number"?new Ge(e):e))}getId(){return U.ByteArray}equals(t){return t.isByteArray()&&this.length===t.length&&this.items.every((e,i)=>e.equals(t.items[i]))}getType(){return U.Byte}toString(){return"[B;"+this.items.map(e=>e.getAsNumber().toFixed()+"B").join(",")+"]"}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.items.map(t=>t.getAsNumber())}toJson(){return this.items.map(t=>t.getAsNumber())}toBytes(t){t.writeInt(this.items.length),t.writeBytes(this.items.map(e=>e.getAsNumber()))}static create(){return new n([])}static fromJson(t){let e=M.readArray(t,i=>M.readNumber(i)??0)??[];return new n(e)}static fromBytes(t){let e=t.readInt(),i=t.readBytes(e);return new n(i)}};J.register(U.ByteArray,Fn);var xr=class n extends J{value;constructor(t){super(),this.value=t}getId(){return U.Float}equals(t){return t.isFloat()&&this.value===t.value}getAsNumber(){return this.value}toString(){return this.value.toString()+"f"}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.value}toJson(){return this.value}toBytes(t){t.writeFloat(this.value)}static create(){return new n(0)}static fromJson(t){return new n(M.readNumber(t)??0)}static fromBytes(t){let e=t.readFloat();return new n(e)}};J.register(U.Float,xr);var Me=class n extends J{value;constructor(t){super(),this.value=t}getId(){return U.Int}equals(t){return t.isInt()&&this.value===t.value}getAsNumber(){return this.value}toString(){return this.value.toFixed()}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.value}toJson(){return this.value}toBytes(t){t.writeInt(this.value)}static create(){return new n(0)}static fromJson(t){return new n(M.readInt(t)??0)}static fromBytes(t){let e=t.readInt();return new n(e)}};J.register(U.Int,Me);var On=class n extends Ve{constructor(t){super(Array.from(t??[],e=>typeof e=="number"?new Me(e):e))}getId(){return U.IntArray}equals(t){return t.isIntArray()&&this.length===t.length&&this.items.every((e,i)=>e.equals(t.items[i]))}getType(){return U.Int}get length(){return this.items.length}toString(){return"[I;"+this.items.map(e=>e.getAsNumber().toFixed()).join(",")+"]"}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.items.map(t=>t.getAsNumber())}toJson(){return this.items.map(t=>t.getAsNumber())}toBytes(t){t.writeInt(this.items.length);for(let e of this.items)t.writeInt(e.getAsNumber())}static create(){return new n}static fromJson(t){let e=M.readArray(t,i=>M.readNumber(i)??0)??[];return new n(e)}static fromBytes(t){let e=t.readInt(),i=[];for(let r=0;r<e;r+=1)i.push(t.readInt());return new n(i)}};J.register(U.IntArray,On);var He=class n extends Ve{type;constructor(t,e){super(t??[]),this.type=this.items.length===0?U.End:e??this.items[0].getId()}static make(t,e){return new n(e.map(i=>new t(i)))}getId(){return U.List}equals(t){return t.isList()&&this.type===t.type&&this.length===t.length&&this.items.every((e,i)=>e.equals(t.items[i]))}getType(){return this.type}getNumber(t){let e=this.get(t);return e?.isNumber()?e.getAsNumber():0}getString(t){let e=this.get(t);return e?.isString()?e.getAsString():""}getList(t,e){let i=this.get(t);return i?.isList()&&i.getType()===e?i:n.create()}getCompound(t){let e=this.get(t);return e?.isCompound()?e:Et.create()}set(t,e){this.updateType(e),super.set(t,e)}add(t){this.updateType(t),super.add(t)}insert(t,e){this.updateType(e),super.insert(t,e)}updateType(t){if(t.getId()!==U.End){if(this.type===U.End)this.type=t.getId();else if(this.type!==t.getId())throw new Error(`Trying to add tag of type ${U[t.getId()]} to list of ${U[this.type]}`)}}clear(){super.clear(),this.type=U.End}toString(){return"["+this.items.map(t=>t.toString()).join(",")+"]"}toPrettyString(t="  ",e=0){if(this.length===0)return"[]";let i=t.repeat(e),r=t.repeat(e+1);return`[
`+this.map(s=>r+s.toPrettyString(t,e+1)).join(`,
`)+`
`+i+"]"}toSimplifiedJson(){return this.map(t=>t.toSimplifiedJson())}toJson(){return{type:this.type,items:this.items.map(t=>t.toJson())}}toBytes(t){this.items.length===0?this.type=U.End:this.type=this.items[0].getId(),t.writeByte(this.type),t.writeInt(this.items.length);for(let e of this.items)e.toBytes(t)}static create(){return new n}static fromJson(t){let e=M.readObject(t)??{},i=M.readNumber(e.type)??U.Compound,r=(M.readArray(e.items)??[]).flatMap(s=>s!==void 0?[J.fromJson(s,i)]:[]);return new n(r,i)}static fromBytes(t){let e=t.readByte(),i=t.readInt();if(e===U.End&&i>0)throw new Error(`Missing type on ListTag but length is ${i}`);let r=[];for(let s=0;s<i;s+=1)r.push(J.fromBytes(t,e));return new n(r,e)}};J.register(U.List,He);var Bn=class n extends J{static dataview=new DataView(new Uint8Array(8).buffer);value;constructor(t){super(),this.value=n.toPair(t)}static toPair(t){return Array.isArray(t)?t:n.bigintToPair(t)}static bigintToPair(t){return n.dataview.setBigInt64(0,t),[n.dataview.getInt32(0),n.dataview.getInt32(4)]}static pairToBigint(t){return n.dataview.setInt32(0,Number(t[0])),n.dataview.setInt32(4,Number(t[1])),n.dataview.getBigInt64(0)}static pairToString(t){return n.pairToBigint(t).toString()}static pairToNumber(t){return Number(n.pairToBigint(t))}getId(){return U.Long}equals(t){return t.isLong()&&this.value[0]===t.value[0]&&this.value[1]===t.value[1]}getAsNumber(){return n.pairToNumber(this.value)}getAsPair(){return this.value}toBigInt(){return n.pairToBigint(this.value)}toString(){return n.pairToString(this.value)+"L"}toPrettyString(){return this.toString()}toSimplifiedJson(){return n.pairToNumber(this.value)}toJson(){return this.value}toBytes(t){t.writeInt(this.value[0]),t.writeInt(this.value[1])}static create(){return new n([0,0])}static fromJson(t){return new n(Array.isArray(t)&&t.length===2?t.map(e=>typeof e=="number"?e:0):[0,0])}static fromBytes(t){let e=t.readInt(),i=t.readInt();return new n([e,i])}};J.register(U.Long,Bn);var zn=class n extends Ve{constructor(t){super(Array.from(t??[],e=>typeof e=="bigint"||Array.isArray(e)?new Bn(e):e))}getId(){return U.LongArray}equals(t){return t.isLongArray()&&this.length===t.length&&this.items.every((e,i)=>e.equals(t.items[i]))}getType(){return U.Long}get length(){return this.items.length}toString(){return"[I;"+this.items.map(e=>e.toString()).join(",")+"]"}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.items.map(t=>t.getAsPair())}toJson(){return this.items.map(t=>t.getAsPair())}toBytes(t){t.writeInt(this.items.length);for(let e of this.items){let[i,r]=e.getAsPair();t.writeInt(i),t.writeInt(r)}}static create(){return new n}static fromJson(t){let e=M.readArray(t,i=>M.readPair(i,r=>M.readNumber(r)??0)??[0,0])??[];return new n(e)}static fromBytes(t){let e=t.readInt(),i=[];for(let r=0;r<e;r+=1)i.push([t.readInt(),t.readInt()]);return new n(i)}};J.register(U.LongArray,zn);var vr=class n extends J{value;constructor(t){super(),this.value=t}getId(){return U.Short}equals(t){return t.isShort()&&this.value===t.value}getAsNumber(){return this.value}toString(){return this.value.toFixed()+"s"}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.value}toJson(){return this.value}toBytes(t){t.writeShort(this.value)}static create(){return new n(0)}static fromJson(t){return new n(typeof t=="number"?Math.floor(t):0)}static fromBytes(t){let e=t.readShort();return new n(e)}};J.register(U.Short,vr);var jt=class n extends J{static EMPTY=new n("");value;constructor(t){super(),this.value=t}getId(){return U.String}equals(t){return t.isString()&&this.value===t.value}getAsString(){return this.value}toString(){return'"'+this.value.replace(/(\\|")/g,"\\$1")+'"'}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.value}toJson(){return this.value}toBytes(t){t.writeString(this.value)}static create(){return n.EMPTY}static fromJson(t){return new n(typeof t=="string"?t:"")}static fromBytes(t){let e=t.readString();return new n(e)}};J.register(U.String,jt);var kn;(function(n){let t=new RegExp("^[-+]?(?:[0-9]+[.]|[0-9]*[.][0-9]+)(?:e[-+]?[0-9]+)?$","i"),e=new RegExp("^[-+]?(?:[0-9]+[.]?|[0-9]*[.][0-9]+)(?:e[-+]?[0-9]+)?d$","i"),i=new RegExp("^[-+]?(?:[0-9]+[.]?|[0-9]*[.][0-9]+)(?:e[-+]?[0-9]+)?f$","i"),r=new RegExp("^[-+]?(?:0|[1-9][0-9]*)b$","i"),s=new RegExp("^[-+]?(?:0|[1-9][0-9]*)l$","i"),a=new RegExp("^[-+]?(?:0|[1-9][0-9]*)s$","i"),o=new RegExp("^[-+]?(?:0|[1-9][0-9]*)$","i");function h(f){if(f.skipWhitespace(),!f.canRead())throw f.createError("Expected value");let p=f.peek();if(p==="{")return l(f);if(p==="[")if(f.canRead(3)&&!xe.isQuotedStringStart(f.peek(1))&&f.peek(2)===";"){f.expect("[",!0);let m=f.cursor,g=f.read();if(f.skip(),f.skipWhitespace(),f.canRead()){if(g==="B")return u(f,Fn,U.ByteArray,U.Byte);if(g==="L")return u(f,zn,U.LongArray,U.Long);if(g==="I")return u(f,On,U.IntArray,U.Int);throw f.cursor=m,f.createError(`Invalid array type '${g}'`)}else throw f.createError("Expected value")}else return c(f);else{f.skipWhitespace();let m=f.cursor;if(xe.isQuotedStringStart(f.peek()))return new jt(f.readQuotedString());{let g=f.readUnquotedString();if(g.length===0)throw f.cursor=m,f.createError("Expected value");try{if(i.test(g)){let _=Number(g.substring(0,g.length-1));return new xr(_)}else if(r.test(g)){let _=Number(g.substring(0,g.length-1));return new Ge(Math.floor(_))}else if(s.test(g)){let _=BigInt(g.substring(0,g.length-1));return new Bn(_)}else if(a.test(g)){let _=Number(g.substring(0,g.length-1));return new vr(Math.floor(_))}else if(o.test(g)){let _=Number(g);return new Me(Math.floor(_))}else if(e.test(g)){let _=Number(g.substring(0,g.length-1));return new Gn(_)}else if(t.test(g)){let _=Number(g);return new Gn(_)}else{if(g.toLowerCase()==="true")return Ge.ONE;if(g.toLowerCase()==="false")return Ge.ZERO}}catch{}return g.length===0?jt.EMPTY:new jt(g)}}}n.readTag=h;function l(f){f.expect("{",!0);let p=new Map;for(f.skipWhitespace();f.canRead()&&f.peek()!=="}";){let m=f.cursor;if(f.skipWhitespace(),!f.canRead())throw f.createError("Expected key");let g=f.readString();if(g.length===0)throw f.cursor=m,f.createError("Expected key");f.expect(":",!0);let _=h(f);if(p.set(g,_),!d(f))break;if(!f.canRead())throw f.createError("Expected key")}return f.expect("}",!0),new Et(p)}function c(f){if(f.expect("[",!0),f.skipWhitespace(),!f.canRead())throw f.createError("Expected value");let p=[],m=U.End;for(;f.peek()!=="]";){let g=f.cursor,_=h(f),y=_.getId();if(m===U.End)m=y;else if(y!==m)throw f.cursor=g,f.createError(`Can't insert ${U[y]} into list of ${U[m]}`);if(p.push(_),!d(f))break;if(!f.canRead())throw f.createError("Expected value")}return f.expect("]",!0),new He(p,m)}function u(f,p,m,g){let _=[];for(;f.peek()!=="]";){let y=h(f);if(y.getId()!==g)throw f.createError(`Can't insert ${U[y.getId()]} into ${U[m]}`);if(_.push(y.isLong()?y.getAsPair():y.getAsNumber()),!d(f))break;if(!f.canRead())throw f.createError("Expected value")}return f.expect("]"),new p(_)}function d(f){return f.skipWhitespace(),f.canRead()&&f.peek()===","?(f.skip(),f.skipWhitespace(),!0):!1}})(kn=kn||(kn={}));var Et=class n extends J{properties;constructor(t){super(),this.properties=t??new Map}getId(){return U.Compound}equals(t){return t.isCompound()&&this.size===t.size&&[...this.properties.entries()].every(([e,i])=>{let r=t.properties.get(e);return r!==void 0&&i.equals(r)})}has(t){return this.properties.has(t)}hasNumber(t){return this.get(t)?.isNumber()??!1}hasString(t){return this.get(t)?.isString()??!1}hasList(t,e,i){let r=this.get(t);return(r?.isList()&&(e===void 0||r.getType()===e)&&(i===void 0||r.length===i))??!1}hasCompound(t){return this.get(t)?.isCompound()??!1}get(t){return this.properties.get(t)}getString(t){return this.get(t)?.getAsString()??""}getNumber(t){return this.get(t)?.getAsNumber()??0}getBoolean(t){return this.getNumber(t)!==0}getList(t,e){let i=this.get(t);return i?.isList()&&(e===void 0||i.getType()===e)?i:He.create()}getCompound(t){let e=this.get(t);return e?.isCompound()?e:n.create()}getByteArray(t){let e=this.get(t);return e?.isByteArray()?e:Fn.create()}getIntArray(t){let e=this.get(t);return e?.isIntArray()?e:On.create()}getLongArray(t){let e=this.get(t);return e?.isLongArray()?e:zn.create()}keys(){return this.properties.keys()}get size(){return this.properties.size}map(t){return Object.fromEntries([...this.properties.entries()].map(([e,i])=>t(e,i,this)))}forEach(t){[...this.properties.entries()].forEach(([e,i])=>t(e,i,this))}set(t,e){return this.properties.set(t,e),this}delete(t){return this.properties.delete(t)}clear(){return this.properties.clear(),this}toString(){let t=[];for(let[e,i]of this.properties.entries()){let r=e.split("").some(s=>!xe.isAllowedInUnquotedString(s));t.push((r?JSON.stringify(e):e)+":"+i.toString())}return"{"+t.join(",")+"}"}toPrettyString(t="  ",e=0){if(this.size===0)return"{}";let i=t.repeat(e),r=t.repeat(e+1),s=[];for(let[a,o]of this.properties.entries()){let h=a.split("").some(l=>!xe.isAllowedInUnquotedString(l));s.push((h?JSON.stringify(a):a)+": "+o.toPrettyString(t,e+1))}return`{
`+s.map(a=>r+a).join(`,
`)+`
`+i+"}"}toSimplifiedJson(){return this.map((t,e)=>[t,e.toSimplifiedJson()])}toJson(){return this.map((t,e)=>[t,{type:e.getId(),value:e.toJson()}])}toBytes(t){for(let[e,i]of this.properties.entries()){let r=i.getId();t.writeByte(r),t.writeString(e),i.toBytes(t)}t.writeByte(U.End)}static create(){return new n}static fromString(t){return kn.readTag(t)}static fromJson(t){let e=M.readMap(t,i=>{let{type:r,value:s}=M.readObject(i)??{},a=M.readNumber(r);return J.fromJson(s??{},a)});return new n(new Map(Object.entries(e)))}static fromBytes(t){let e=new Map;for(;;){let i=t.readByte();if(i===U.End)break;let r=t.readString(),s=J.fromBytes(t,i);e.set(r,s)}return new n(e)}};J.register(U.Compound,Et);var xn=class n{name;root;compression;littleEndian;bedrockHeader;static DEFAULT_NAME="";static DEFAULT_BEDROCK_HEADER=4;constructor(t,e,i,r,s){this.name=t,this.root=e,this.compression=i,this.littleEndian=r,this.bedrockHeader=s}writeNamedTag(t){t.writeByte(U.Compound),t.writeString(this.name),this.root.toBytes(t)}write(){let t=this.littleEndian===!0||this.bedrockHeader!==void 0,e=new Ts({littleEndian:t,offset:this.bedrockHeader&&8});if(this.writeNamedTag(e),this.bedrockHeader!==void 0){let r=e.offset;e.offset=0,e.writeInt(this.bedrockHeader),e.writeInt(r-8),e.offset=r}let i=e.getData();return this.compression==="gzip"?ks.gzip(i):this.compression==="zlib"?ks.deflate(i):i}static readNamedTag(t){if(t.readByte()!==U.Compound)throw new Error("Top tag should be a compound");return{name:t.readString(),root:Et.fromBytes(t)}}static create(t={}){let e=t.name??n.DEFAULT_NAME,i=Et.create(),r=t.compression??"none",s=typeof t.bedrockHeader=="boolean"?n.DEFAULT_BEDROCK_HEADER:t.bedrockHeader,a=t.littleEndian??t.bedrockHeader!==void 0;return new n(e,i,r,a,s)}static read(t,e={}){let i=typeof e.bedrockHeader=="number"?e.bedrockHeader:e.bedrockHeader?Wh(t):void 0,r=e.compression==="gzip"||!i&&e.compression===void 0&&Vh(t),s=e.compression==="zlib"||!i&&e.compression===void 0&&Hh(t),a=s||r?ks.inflate(t):t,o=e.littleEndian||i!==void 0,h=r?"gzip":s?"zlib":"none",l=new As(a,{littleEndian:o,offset:i&&8}),{name:c,root:u}=n.readNamedTag(l);return new n(e.name??c,u,h,o,i)}toJson(){return{name:this.name,root:this.root.toJson(),compression:this.compression,littleEndian:this.littleEndian,bedrockHeader:this.bedrockHeader??null}}static fromJson(t){let e=M.readObject(t)??{},i=M.readString(e.name)??"",r=Et.fromJson(e.root??{}),s=M.readString(e.compression)??"none",a=M.readBoolean(e.littleEndian)??!1,o=M.readNumber(e.bedrockHeader);return new n(i,r,s,a,o)}};var vn=class n{x;z;compression;timestamp;raw;file;dirty;constructor(t,e,i,r,s){this.x=t,this.z=e,this.compression=i,this.timestamp=r,this.raw=s,this.dirty=!1}getCompression(){switch(this.compression){case 1:return"gzip";case 2:return"zlib";case 3:return"none";default:throw new Error(`Invalid compression mode ${this.compression}`)}}setCompression(t){switch(t){case"gzip":this.compression=1;break;case"zlib":this.compression=2;break;case"none":this.compression=3;break;default:throw new Error(`Invalid compression mode ${t}`)}}getFile(){return this.file===void 0&&(this.file=xn.read(this.raw,{compression:this.getCompression()})),this.file}getRoot(){return this.getFile().root}setRoot(t){this.file===void 0&&(this.file=xn.create({compression:this.getCompression()})),this.file.root=t,this.markDirty()}markDirty(){this.dirty=!0}getRaw(){if(this.file===void 0||this.dirty===!1)return this.raw;this.file.compression=this.getCompression();let t=this.file.write();return this.raw=t,this.dirty=!1,t}toJson(){return{x:this.x,z:this.z,compression:this.compression,timestamp:this.timestamp,size:this.raw.byteLength}}toRef(t){return new n.Ref(this.x,this.z,this.compression,this.timestamp,this.raw.byteLength,t)}static create(t,e,i,r){let s=new n(t,e,0,r??0,i.write());return s.setCompression(i.compression),s}static fromJson(t,e){let i=M.readObject(t)??{},r=M.readInt(i.x)??0,s=M.readInt(i.z)??0,a=M.readNumber(i.compression)??2,o=M.readInt(i.timestamp)??0,h=M.readInt(i.size)??0;return new n.Ref(r,s,a,o,h,e)}};(function(n){class t{x;z;compression;timestamp;size;resolver;file;constructor(i,r,s,a,o,h){this.x=i,this.z=r,this.compression=s,this.timestamp=a,this.size=o,this.resolver=h}getFile(){if(this.file instanceof xn)return this.file}getRoot(){if(this.file instanceof xn)return this.file.root}async getFileAsync(){return this.file?this.file:(this.file=(async()=>{let i=await this.resolver(this.x,this.z);return this.file=i,i})(),this.file)}async getRootAsync(){return(await this.getFileAsync()).root}isResolved(){return this.file instanceof xn}}n.Ref=t})(vn=vn||(vn={}));var Gs=class{chunks;constructor(t){this.chunks=Array(1024).fill(void 0);for(let e of t){let i=Vn.getIndex(e.x,e.z);this.chunks[i]=e}}getChunkPositions(){return this.chunks.flatMap(t=>t?[[t.x,t.z]]:[])}getChunk(t){if(!(t<0||t>=1024))return this.chunks[t]}findChunk(t,e){return this.getChunk(Vn.getIndex(t,e))}getFirstChunk(){return this.chunks.filter(t=>t!==void 0)[0]}filter(t){return this.chunks.filter(e=>e!==void 0&&t(e))}map(t){return this.chunks.flatMap(e=>e!==void 0?[t(e)]:[])}},Vn=class n extends Gs{constructor(t){super(t)}write(){let t=0;for(let s of this.chunks)s!==void 0&&(t+=Math.ceil(s.getRaw().length/4096));let e=new Uint8Array(8192+t*4096),i=new DataView(e.buffer),r=2;for(let s of this.chunks){if(s===void 0)continue;let a=s.getRaw(),o=4*((s.x&31)+(s.z&31)*32),h=Math.ceil(a.length/4096);i.setInt8(o,r>>16),i.setInt16(o+1,r&65535),i.setInt8(o+3,h),i.setInt32(o+4096,s.timestamp);let l=r*4096;i.setInt32(l,a.length+1),i.setInt8(l+4,s.compression),e.set(a,l+5),r+=h}return e}static read(t){let e=[];for(let i=0;i<32;i+=1)for(let r=0;r<32;r+=1){let s=4*((i&31)+(r&31)*32);if(t[s+3]===0)continue;let o=(t[s]<<16)+(t[s+1]<<8)+t[s+2],h=(t[s+4096]<<24)+(t[s+4097]<<16)+(t[s+4098]<<8)+t[s+4099],l=o*4096,c=(t[l]<<24)+(t[l+1]<<16)+(t[l+2]<<8)+t[l+3],u=t[l+4],d=t.slice(l+5,l+4+c);e.push(new vn(i,r,u,h,d))}return new n(e)}static getIndex(t,e){return(t&31)+(e&31)*32}toJson(){return{chunks:this.map(t=>t.toJson())}}static fromJson(t,e){let i=M.readObject(t)??{},s=(M.readArray(i.chunks)??[]).flatMap(a=>a!==void 0?[vn.fromJson(a,e)]:[]);return new n.Ref(s)}};(function(n){class t extends Gs{}n.Ref=t})(Vn=Vn||(Vn={}));var Gn=class n extends J{value;constructor(t){super(),this.value=t}getId(){return U.Double}equals(t){return t.isDouble()&&this.value===t.value}getAsNumber(){return this.value}toString(){return Number.isInteger(this.value)?this.value.toFixed(1):this.value.toString()}toPrettyString(){return this.toString()}toSimplifiedJson(){return this.value}toJson(){return this.value}toBytes(t){t.writeDouble(this.value)}static create(){return new n(0)}static fromJson(t){return new n(M.readNumber(t)??0)}static fromBytes(t){let e=t.readDouble();return new n(e)}};J.register(U.Double,Gn);var Ml=class n extends J{static INSTANCE=new n;constructor(){super()}getId(){return U.End}equals(t){return t.isEnd()}toString(){return"END"}toPrettyString(){return this.toString()}toSimplifiedJson(){return null}toJson(){return null}toBytes(){}static create(){return n.INSTANCE}static fromJson(){return n.INSTANCE}static fromBytes(){return n.INSTANCE}};J.register(U.End,Ml);var At;(function(n){n.UP="up",n.DOWN="down",n.NORTH="north",n.EAST="east",n.SOUTH="south",n.WEST="west"})(At=At||(At={}));var qM={[At.UP]:[0,1,0],[At.DOWN]:[0,-1,0],[At.NORTH]:[0,0,-1],[At.EAST]:[1,0,0],[At.SOUTH]:[0,0,1],[At.WEST]:[-1,0,0]};(function(n){n.ALL=[n.UP,n.DOWN,n.NORTH,n.EAST,n.SOUTH,n.WEST];function t(e){return qM[e]}n.normal=t})(At=At||(At={}));var ot;(function(n){function t(u,d,f){return[u,d,f]}n.create=t,n.ZERO=n.create(0,0,0);function e(u,d,f,p){return[u[0]+d,u[1]+f,u[2]+p]}n.offset=e;function i(u,d){return[u[0]-d[0],u[1]-d[1],u[2]-d[2]]}n.subtract=i;function r(u,d){return[u[0]+d[0],u[1]+d[1],u[2]+d[2]]}n.add=r;function s(u,d){return n.offset(u,...At.normal(d))}n.towards=s;function a(u,d){return u===d?!0:u[0]===d[0]&&u[1]===d[1]&&u[2]===d[2]}n.equals=a;function o(u){return u[0]*u[0]+u[1]*u[1]+u[2]*u[2]}n.magnitude=o;function h(u){return new He(u.map(d=>new Me(d)))}n.toNbt=h;function l(u){return u.getAsTuple(3,d=>d?.isInt()?d.getAsNumber():0)}n.fromNbt=l;function c(u){let d=M.readArray(u,f=>M.readInt(f)??0)??[0,0,0];return t(d[0],d[1],d[2])}n.fromJson=c})(ot=ot||(ot={}));var T=class n{namespace;path;static DEFAULT_NAMESPACE="minecraft";static SEPARATOR=":";constructor(t,e){this.namespace=t,this.path=e}is(t){return this.equals(n.parse(t))}equals(t){return this===t?!0:t instanceof n?this.namespace===t.namespace&&this.path===t.path:!1}toString(){return this.namespace+n.SEPARATOR+this.path}withPrefix(t){return new n(this.namespace,t+this.path)}static create(t){return new n(this.DEFAULT_NAMESPACE,t)}static parse(t){let e=t.indexOf(this.SEPARATOR);if(e>=0){let i=e>=1?t.substring(0,e):this.DEFAULT_NAMESPACE,r=t.substring(e+1);return new n(i,r)}return new n(this.DEFAULT_NAMESPACE,t)}};var Tt=class n{properties;static AIR=new n(T.create("air"));static STONE=new n(T.create("stone"));static WATER=new n(T.create("water"),{level:"0"});static LAVA=new n(T.create("lava"),{level:"0"});name;constructor(t,e={}){this.properties=e,this.name=typeof t=="string"?T.parse(t):t}getName(){return this.name}getProperties(){return this.properties}getProperty(t){return this.properties[t]}isFluid(){return this.is(n.WATER)||this.is(n.LAVA)}isWaterlogged(){return this.is(n.WATER)||this.is(n.LAVA)||this.is("bubble_column")||this.is("kelp")||this.is("kelp_plant")||this.is("seagrass")||this.is("tall_seagrass")||this.properties.waterlogged==="true"}equals(t){return!this.name.equals(t.name)||Object.keys(this.properties).length!==Object.keys(t.properties).length?!1:Object.keys(this.properties).every(e=>t.properties[e]===this.properties[e])}is(t){return typeof t=="string"?this.name.equals(T.parse(t)):t instanceof T?this.name.equals(t):this.name.equals(t.name)}toString(){return Object.keys(this.properties).length===0?this.name.toString():`${this.name.toString()}[${Object.entries(this.properties).map(([t,e])=>t+"="+e).join(",")}]`}static parse(t){let e=t.indexOf("[");if(e===-1)return new n(t);{let i=t.substring(0,e),r=t.substring(e+1,t.length-1).split(","),s=Object.fromEntries(r.map(a=>a.split("=")));return new n(i,s)}}static fromNbt(t){if(t.isString())return new n(t.getAsString());let e=t.isCompound()?t:new Et,i=T.parse(e.hasString("id")?e.getString("id"):e.getString("Name")),r=(e.hasCompound("properties")?e.getCompound("properties"):e.getCompound("Properties")).map((s,a)=>[s,a.getAsString()]);return new n(i,r)}static fromJson(t){if(typeof t=="string")return new n(t);let e=M.readObject(t)??{},i=T.parse(M.readString(e.id??e.Name)??""),r=M.readMap(e.properties??e.Properties,s=>M.readString(s)??"");return new n(i,r)}};var Vs=class{size;defaultValue;storage;palette;constructor(t,e){this.size=t,this.defaultValue=e,this.storage=Array(t).fill(0),this.palette=[e]}index(t,e,i){return(t<<8)+(e<<4)+i}get(t,e,i){let r=this.storage[this.index(t,e,i)];return this.palette[r]}set(t,e,i,r){let s=this.palette.findIndex(a=>a.equals(r));s===-1&&(s=this.palette.length,this.palette.push(r)),this.storage[this.index(t,e,i)]=s}};var bl=class n{minY;static WIDTH=16;static SIZE=n.WIDTH*n.WIDTH*n.WIDTH;states;constructor(t){this.minY=t,this.states=new Vs(n.SIZE,Tt.AIR)}get minBlockY(){return this.minY<<4}getBlockState(t,e,i){return this.states.get(t,e,i)}setBlockState(t,e,i,r){this.states.set(t,e,i,r)}};var wi;(function(n){function t(c,u){return[c,u]}n.create=t;function e(c){return[c[0]>>4,c[2]>>4]}n.fromBlockPos=e;function i(c){return[Number(c)&4294967295,Number(c>>BigInt(32))]}n.fromLong=i;function r(c){return s(c[0],c[1])}n.toLong=r;function s(c,u){return BigInt(c&4294967295)|BigInt(u&4294967295)<<BigInt(32)}n.asLong=s;function a(c){return c[0]<<4}n.minBlockX=a;function o(c){return c[1]<<4}n.minBlockZ=o;function h(c){return(c[0]<<4)+15}n.maxBlockX=h;function l(c){return(c[1]<<4)+15}n.maxBlockZ=l})(wi=wi||(wi={}));var YM=new Map([["minecraft:speed",3402751],["minecraft:slowness",9154528],["minecraft:haste",14270531],["minecraft:mining_fatigue",4866583],["minecraft:strength",16762624],["minecraft:instant_health",16262179],["minecraft:instant_damage",11101546],["minecraft:jump_boost",16646020],["minecraft:nausea",5578058],["minecraft:regeneration",13458603],["minecraft:resistance",9520880],["minecraft:fire_resistance",16750848],["minecraft:water_breathing",10017472],["minecraft:invisibility",16185078],["minecraft:blindness",2039587],["minecraft:night_vision",12779366],["minecraft:hunger",5797459],["minecraft:weakness",4738376],["minecraft:poison",8889187],["minecraft:wither",7561558],["minecraft:health_boost",16284963],["minecraft:absorption",2445989],["minecraft:saturation",16262179],["minecraft:glowing",9740385],["minecraft:levitation",13565951],["minecraft:luck",5882118],["minecraft:unluck",12624973],["minecraft:slow_falling",15978425],["minecraft:conduit_power",1950417],["minecraft:dolphins_grace",8954814],["minecraft:bad_omen",745784],["minecraft:hero_of_the_village",4521796],["minecraft:darkness",2696993],["minecraft:trial_omen",1484454],["minecraft:raid_omen",14565464],["minecraft:wind_charged",12438015],["minecraft:weaving",7891290],["minecraft:oozing",10092451],["minecraft:infested",9214860]]),Hs;(function(n){function t(e){return{effect:T.parse(e.getString("id")),duration:e.getNumber("duration"),amplifier:e.getNumber("amplifier")}}n.fromNbt=t})(Hs=Hs||(Hs={}));var ZM=new Map([["minecraft:empty",[]],["minecraft:water",[]],["minecraft:mundane",[]],["minecraft:thick",[]],["minecraft:awkward",[]],["minecraft:night_vision",[{effect:T.create("night_vision"),duration:3600,amplifier:0}]],["minecraft:long_night_vision",[{effect:T.create("night_vision"),duration:9600,amplifier:0}]],["minecraft:invisibility",[{effect:T.create("invisibility"),duration:3600,amplifier:0}]],["minecraft:long_invisibility",[{effect:T.create("invisibility"),duration:9600,amplifier:0}]],["minecraft:leaping",[{effect:T.create("jump_boost"),duration:3600,amplifier:0}]],["minecraft:long_leaping",[{effect:T.create("jump_boost"),duration:9600,amplifier:0}]],["minecraft:strong_leaping",[{effect:T.create("jump_boost"),duration:1800,amplifier:1}]],["minecraft:fire_resistance",[{effect:T.create("fire_resistance"),duration:3600,amplifier:0}]],["minecraft:long_fire_resistance",[{effect:T.create("fire_resistance"),duration:9600,amplifier:0}]],["minecraft:swiftness",[{effect:T.create("speed"),duration:3600,amplifier:0}]],["minecraft:long_swiftness",[{effect:T.create("speed"),duration:9600,amplifier:0}]],["minecraft:strong_swiftness",[{effect:T.create("speed"),duration:1800,amplifier:1}]],["minecraft:slowness",[{effect:T.create("slowness"),duration:1800,amplifier:0}]],["minecraft:long_slowness",[{effect:T.create("slowness"),duration:4800,amplifier:0}]],["minecraft:strong_slowness",[{effect:T.create("slowness"),duration:400,amplifier:3}]],["minecraft:turtle_master",[{effect:T.create("slowness"),duration:400,amplifier:3},{effect:T.create("resistance"),duration:400,amplifier:2}]],["minecraft:long_turtle_master",[{effect:T.create("slowness"),duration:800,amplifier:3},{effect:T.create("resistance"),duration:800,amplifier:2}]],["minecraft:strong_turtle_master",[{effect:T.create("slowness"),duration:400,amplifier:5},{effect:T.create("resistance"),duration:400,amplifier:3}]],["minecraft:water_breathing",[{effect:T.create("water_breathing"),duration:3600,amplifier:0}]],["minecraft:long_water_breathing",[{effect:T.create("water_breathing"),duration:9600,amplifier:0}]],["minecraft:healing",[{effect:T.create("instant_health"),duration:1,amplifier:0}]],["minecraft:strong_healing",[{effect:T.create("instant_health"),duration:1,amplifier:1}]],["minecraft:harming",[{effect:T.create("instant_damage"),duration:1,amplifier:0}]],["minecraft:strong_harming",[{effect:T.create("instant_damage"),duration:1,amplifier:1}]],["minecraft:poison",[{effect:T.create("poison"),duration:900,amplifier:0}]],["minecraft:long_poison",[{effect:T.create("poison"),duration:1800,amplifier:0}]],["minecraft:strong_poison",[{effect:T.create("poison"),duration:432,amplifier:1}]],["minecraft:regeneration",[{effect:T.create("regeneration"),duration:900,amplifier:0}]],["minecraft:long_regeneration",[{effect:T.create("regeneration"),duration:1800,amplifier:0}]],["minecraft:strong_regeneration",[{effect:T.create("regeneration"),duration:450,amplifier:1}]],["minecraft:strength",[{effect:T.create("strength"),duration:3600,amplifier:0}]],["minecraft:long_strength",[{effect:T.create("strength"),duration:9600,amplifier:0}]],["minecraft:strong_strength",[{effect:T.create("strength"),duration:1800,amplifier:1}]],["minecraft:weakness",[{effect:T.create("weakness"),duration:1800,amplifier:0}]],["minecraft:long_weakness",[{effect:T.create("weakness"),duration:4800,amplifier:0}]],["minecraft:luck",[{effect:T.create("luck"),duration:6e3,amplifier:0}]],["minecraft:slow_falling",[{effect:T.create("slow_falling"),duration:1800,amplifier:0}]],["minecraft:long_slow_falling",[{effect:T.create("slow_falling"),duration:4800,amplifier:0}]],["minecraft:wind_charged",[{effect:T.create("wind_charged"),duration:3600,amplifier:0}]],["minecraft:weaving",[{effect:T.create("weaving"),duration:3600,amplifier:0}]],["minecraft:oozing",[{effect:T.create("oozing"),duration:3600,amplifier:0}]],["minecraft:infested",[{effect:T.create("infested"),duration:3600,amplifier:0}]]]),Ei;(function(n){function t(s){let a={};return s.isString()?a.potion=T.parse(s.getAsString()):s.isCompound()&&(s.hasString("potion")&&(a.potion=T.parse(s.getString("potion"))),s.hasNumber("custom_color")&&(a.customColor=s.getNumber("custom_color")),s.hasList("custom_effects")&&(a.customEffects=s.getList("custom_effects",U.Compound).map(Hs.fromNbt))),a}n.fromNbt=t;function e(s){if(s.customColor)return Z.intToRgb(s.customColor);let a=i(s);return r(a)}n.getColor=e;function i(s){let a=[];return s.potion&&a.push(...ZM.get(s.potion.toString())??[]),s.customEffects&&a.push(...s.customEffects),a}n.getAllEffects=i;function r(s){let[a,o,h]=[0,0,0],l=0;for(let c of s){let u=YM.get(c.effect.toString());if(u===void 0)continue;let d=Z.intToRgb(u),f=c.amplifier+1;a+=f*d[0],o+=f*d[1],h+=f*d[2],l+=f}return l===0?Z.intToRgb(-13083194):(a=a/l,o=o/l,h=h/l,[a,o,h])}})(Ei=Ei||(Ei={}));var lt;(function(n){function t(r,s){return a=>typeof a=="string"?i(r,T.parse(a)):e(s(a))}n.parser=t;function e(r,s){return{value:()=>r,key:()=>s}}n.direct=e;function i(r,s,a=!0){return a?{value:()=>r.getOrThrow(s),key:()=>s}:{value:()=>r.get(s),key:()=>s}}n.reference=i})(lt=lt||(lt={}));var yn=class n{entries;constructor(t){this.entries=t}static parser(t,e){let i=e??(r=>lt.reference(t,T.parse(M.readString(r)??"")));return r=>typeof r=="string"?r.startsWith("#")?lt.reference(t.getTagRegistry(),T.parse(r.substring(1))):lt.direct(new n([lt.reference(t,T.parse(r))])):lt.direct(new n(M.readArray(r,i)??[])??[])}static fromJson(t,e,i){let r=M.readObject(e)??{},s=M.readBoolean(r.replace)??!1,a=M.readArray(r.values,o=>{var h=!0,l="";if(typeof o=="string")l=o;else{let c=M.readObject(o)??{};h=M.readBoolean(c.required)??!1,l=M.readString(c.id)??""}return l.startsWith("#")?lt.reference(t.getTagRegistry(),T.parse(l.substring(1)),h):lt.reference(t,T.parse(l),h)})??[];return i&&!s&&t.getTagRegistry().has(i)&&a?.push(lt.direct(t.getTagRegistry().get(i))),new n(a)}*getEntries(){for(let t of this.entries){let e=t.value();e!==void 0&&(e instanceof n?yield*e.getEntries():yield t)}}};var yr=class n{id;count;components;constructor(t,e,i=new Map){this.id=t,this.count=e,this.components=i}getComponent(t,e){if(typeof t=="string"&&(t=T.parse(t)),this.components.has("!"+t.toString()))return;let i=this.components.get(t.toString());if(i)return i;if(e)return e.getItemComponents(this.id)?.get(t.toString())}hasComponent(t,e){return typeof t=="string"&&(t=T.parse(t)),this.components.has("!"+t.toString())?!1:this.components.has(t.toString())?!0:e?e.getItemComponents(this.id)?.has(t.toString()):!1}clone(){let t=new Map(this.components);return new n(this.id,this.count,t)}is(t){return typeof t=="string"?this.id.equals(T.parse(t)):t instanceof T?this.id.equals(t):this.id.equals(t.id)}equals(t){return this===t?!0:t instanceof n?this.count===t.count&&this.isSameItemSameComponents(t):!1}isSameItemSameComponents(t){if(!this.id.equals(t.id)||this.components.size!==t.components.size)return!1;for(let[e,i]of this.components){let r=t.components.get(e);if(i.toString()!==r?.toString())return!1}return!0}toString(){let t=this.id.toString();return this.components.size>0&&(t+=`[${[...this.components.entries()].map(([e,i])=>e.startsWith("!")?e:`${e}=${i.toString()}`).join(",")}]`),this.count>1&&(t+=` ${this.count}`),t}static fromString(t){let e=new xe(t);for(;e.canRead()&&e.peek()!=="[";)e.skip();let i=T.parse(e.getRead());if(!e.canRead())return new n(i,1);let r=new Map;if(e.skip(),e.peek()==="]")return new n(i,1,r);do{if(e.peek()==="!"){e.skip(),e.skipWhitespace();let s=e.cursor;for(;e.canRead()&&e.peek()!=="]"&&e.peek()!==",";)e.skip();r.set("!"+T.parse(e.getRead(s).trim()).toString(),new Et)}else{e.skipWhitespace();let s=e.cursor;for(;e.canRead()&&e.peek()!=="=";)e.skip();let a=T.parse(e.getRead(s).trim()).toString();if(!e.canRead())break;e.skip(),e.skipWhitespace();let o=kn.readTag(e);r.set(a,o)}if(e.skipWhitespace(),!e.canRead())break;if(e.peek()==="]")return new n(i,1,r);if(e.peek()!==",")throw new Error("Expected , or ]");e.skip()}while(e.canRead());throw new Error("Missing closing ]")}toNbt(){let t=new Et().set("id",new jt(this.id.toString()));return this.count>1&&t.set("count",new Me(this.count)),this.components.size>0&&t.set("components",new Et(this.components)),t}static fromNbt(t){let e=T.parse(t.getString("id")),i=t.hasNumber("count")?t.getNumber("count"):1,r=new Map(Object.entries(t.getCompound("components").map((s,a)=>s.startsWith("!")?["!"+T.parse(s).toString(),new Et]:[T.parse(s).toString(),a])));return new n(e,i,r)}};var Gt=class n{key;parser;static REGISTRY=new n(T.create("root"));storage=new Map;builtin=new Map;tags=void 0;constructor(t,e){this.key=t,this.parser=e}static createAndRegister(t,e){let i=new n(T.create(t),e);return n.REGISTRY.register(i.key,i),i}register(t,e,i){return this.storage.set(t.toString(),e),i&&this.builtin.set(t.toString(),e),lt.reference(this,t)}delete(t){let e=this.storage.delete(t.toString());return this.builtin.delete(t.toString()),e}keys(){return[...this.storage.keys()].map(t=>T.parse(t))}has(t){return this.storage.has(t.toString())}get(t){var e=this.storage.get(t.toString());return e instanceof Function&&(e=e(),this.storage.set(t.toString(),e)),e}getOrThrow(t){let e=this.get(t);if(e===void 0)throw new Error(`Missing key in ${this.key.toString()}: ${t.toString()}`);return e}parse(t){if(!this.parser)throw new Error(`No parser exists for ${this.key.toString()}`);return this.parser(t)}clear(){this.storage.clear();for(let[t,e]of this.builtin.entries())this.storage.set(t,e);return this.tags&&this.tags.clear(),this}assign(t){if(!this.key.equals(t.key))throw new Error(`Cannot assign registry of type ${t.key.toString()} to registry of type ${this.key.toString()}`);for(let e of t.keys())this.storage.set(e.toString(),t.getOrThrow(e));return this}cloneEmpty(){return new n(this.key,this.parser)}forEach(t){for(let[e,i]of this.storage.entries())t(T.parse(e),i instanceof Function?i():i,this)}map(t){return[...this.storage.entries()].map(([e,i])=>t(T.parse(e),i instanceof Function?i():i,this))}getTagRegistry(){return this.tags===void 0&&(this.tags=new n(new T(this.key.namespace,`tags/${this.key.path}`))),this.tags}};var Xt;(function(n){n.NONE="none",n.CLOCKWISE_90="clockwise_90",n.CLOCKWISE_180="180",n.COUNTERCLOCKWISE_90="counterclockwise_90"})(Xt=Xt||(Xt={}));(function(n){function t(e){return[n.NONE,n.CLOCKWISE_90,n.CLOCKWISE_180,n.COUNTERCLOCKWISE_90][e.nextInt(4)]}n.getRandom=t})(Xt=Xt||(Xt={}));var Hn=class n{size;palette;blocks;static REGISTRY=Gt.createAndRegister("structures");static EMPTY=new n(ot.ZERO);blocksMap=[];constructor(t,e=[],i=[]){this.size=t,this.palette=e,this.blocks=i,i.forEach(r=>{if(!this.isInside(r.pos))throw new Error(`Found block at ${r.pos} which is outside the structure bounds ${this.size}`);this.blocksMap[r.pos[0]*t[1]*t[2]+r.pos[1]*t[2]+r.pos[2]]=r})}getSize(){return this.size}addBlock(t,e,i,r){if(!this.isInside(t))throw new Error(`Cannot add block at ${t} outside the structure bounds ${this.size}`);let s=new Tt(e,i),a=this.palette.findIndex(o=>o.equals(s));return a===-1&&(a=this.palette.length,this.palette.push(s)),this.blocks.push({pos:t,state:a,nbt:r}),this.blocksMap[t[0]*this.size[1]*this.size[2]+t[1]*this.size[2]+t[2]]={pos:t,state:a,nbt:r},this}getBlocks(){return this.blocks.map(t=>this.toPlacedBlock(t))}getBlock(t){if(!this.isInside(t))return null;let e=this.blocksMap[t[0]*this.size[1]*this.size[2]+t[1]*this.size[2]+t[2]];return e?this.toPlacedBlock(e):null}toPlacedBlock(t){let e=this.palette[t.state];if(!e)throw new Error(`Block at ${t.pos.join(" ")} in structure references invalid palette index ${t.state}`);return{pos:t.pos,state:e,nbt:t.nbt}}isInside(t){return t[0]>=0&&t[0]<this.size[0]&&t[1]>=0&&t[1]<this.size[1]&&t[2]>=0&&t[2]<this.size[2]}static fromNbt(t){let e=ot.fromNbt(t.getList("size")),i=t.getList("palette",U.Compound).map(s=>Tt.fromNbt(s)),r=t.getList("blocks",U.Compound).map(s=>{let a=ot.fromNbt(s.getList("pos")),o=s.getNumber("state"),h=s.getCompound("nbt");return{pos:a,state:o,nbt:h.size>0?h:void 0}});return new n(e,i,r)}static transform(t,e,i){switch(e){case Xt.COUNTERCLOCKWISE_90:return ot.create(i[0]-i[2]+t[2],t[1],i[0]+i[2]-t[0]);case Xt.CLOCKWISE_90:return ot.create(i[0]+i[2]-t[2],t[1],i[2]-i[0]+t[0]);case Xt.CLOCKWISE_180:return ot.create(i[0]+i[0]-t[0],t[1],i[2]+i[2]-t[2]);default:return t}}};var Ce=[124/255,189/255,107/255],JM=Z.intToRgb(6396257),$M=Z.intToRgb(8431445),Ai=Z.intToRgb(4764952),Ws=Z.intToRgb(4159204),KM=Z.intToRgb(2129968),QM=n=>{let t=n/15,e=t*.6+(t>0?.4:.3),i=Ot(t*t*.7-.5,0,1),r=Ot(t*t*.6-.7,0,1);return[e,i,r]},Xs=n=>[n/8,1-n/32,n/64],Ie={large_fern:()=>Ce,tall_grass:()=>Ce,grass_block:()=>Ce,fern:()=>Ce,grass:()=>Ce,short_grass:()=>Ce,potted_fern:()=>Ce,pink_petals:()=>Ce,wildflowers:()=>Ce,bush:()=>Ce,spruce_leaves:()=>JM,birch_leaves:()=>$M,oak_leaves:()=>Ai,jungle_leaves:()=>Ai,acacia_leaves:()=>Ai,dark_oak_leaves:()=>Ai,vine:()=>Ai,mangrove_leaves:()=>Ai,water:()=>Ws,bubble_column:()=>Ws,cauldron:()=>Ws,water_cauldron:()=>Ws,redstone_wire:n=>QM(parseInt(n.power??"0")),sugar_cane:()=>Ce,attached_melon_stem:()=>Xs(7),attached_pumpkin_stem:()=>Xs(7),melon_stem:n=>Xs(parseInt(n.age??"0")),pumpkin_stem:n=>Xs(parseInt(n.age??"0")),lily_pad:()=>KM};var ht;(function(n){function t(i,r,s){let{up:a,down:o,north:h,east:l,south:c,west:u}=i;switch(s){case 90:[h,l,c,u]=[l,c,u,h];break;case 180:[h,l,c,u]=[c,u,h,l];break;case 270:[h,l,c,u]=[u,h,l,c]}switch(r){case 90:[a,h,o,c]=[h,o,c,a];break;case 180:[a,h,o,c]=[o,c,a,h];break;case 270:[a,h,o,c]=[c,a,h,o]}return{up:a,down:o,north:h,east:l,south:c,west:u}}n.rotate=t;function e(){return Object.create(null)}n.none=e})(ht=ht||(ht={}));var Vt;(function(n){function t(a){let o=M.readObject(a)??{};return o.absolute!==void 0?e(M.readNumber(o.absolute)??0):o.above_bottom!==void 0?i(M.readNumber(o.above_bottom)??0):o.below_top!==void 0?r(M.readNumber(o.below_top)??0):o.relative_to_sea_level!==void 0?s(M.readNumber(o.relative_to_sea_level)??0):()=>0}n.fromJson=t;function e(a){return()=>a}n.absolute=e;function i(a){return o=>o.minY+a}n.aboveBottom=i;function r(a){return o=>o.minY+o.height-1-a}n.belowTop=r;function s(a){return o=>o.seaLevel+a}n.relativeToSeaLevel=s})(Vt=Vt||(Vt={}));var We=class{};(function(n){n.NOOP={compile:()=>()=>{}};function t(a){if(typeof a=="string")return new e(lt.reference(qt.MATERIAL_RULE,T.parse(a)));let o=M.readObject(a)??{};switch(M.readString(o.type)?.replace(/^minecraft:/,"")){case"block":return new i(Tt.fromJson(o.result_state));case"sequence":return new r(M.readArray(o.sequence,n.fromJson)??[]);case"condition":return new s(Sn.fromJson(o.if_true),n.fromJson(o.then_run));default:return n.NOOP}}n.fromJson=t;class e extends n{holder;constructor(o){super(),this.holder=o}compile(o){return this.holder.value().compile(o)}}n.HolderHolder=e;class i extends n{resultState;constructor(o){super(),this.resultState=o}compile(o){return()=>this.resultState}}n.Block=i;class r extends n{sequence;constructor(o){super(),this.sequence=o}compile(o){if(this.sequence.length===0)return()=>{};if(this.sequence.length===1)return this.sequence[0].compile(o);let h=this.sequence.map(l=>l.compile(o));return(l,c,u)=>{for(let d of h){let f=d(l,c,u);if(f)return f}}}}n.Sequence=r;class s extends n{ifTrue;thenRun;constructor(o,h){super(),this.ifTrue=o,this.thenRun=h}compile(o){let h=this.ifTrue.compile(o),l=this.thenRun.compile(o);return(c,u,d)=>{if(h())return l(c,u,d)}}}n.Condition=s})(We=We||(We={}));var Sn=class{};(function(n){n.ALWAYS_FALSE={compile:()=>()=>!1},n.ALWAYS_TRUE={compile:()=>()=>!0};function t(d){if(typeof d=="string")return new i(lt.reference(qt.MATERIAL_CONDITION,T.parse(d)));let f=M.readObject(d)??{};switch(M.readString(f.type)?.replace(/^minecraft:/,"")){case"above_preliminary_surface":return new r;case"biome":return new s(yn.parser(qt.BIOME)(f.biome_is));case"noise_threshold":return new a(T.parse(M.readString(f.noise)??""),M.readNumber(f.min_threshold)??0,M.readNumber(f.max_threshold)??0,M.readBoolean(f.is_3d)??!1);case"not":return new o(n.fromJson(f.invert));case"stone_depth":return new h(M.readInt(f.offset)??0,M.readBoolean(f.add_surface_depth)??!1,M.readInt(f.secondary_depth_range)??0,M.readString(f.surface_type)==="ceiling");case"vertical_gradient":return new l(T.parse(M.readString(f.random_name)??""),Vt.fromJson(f.true_at_and_below),Vt.fromJson(f.false_at_and_above));case"water":return new c(M.readInt(f.offset)??0,M.readInt(f.surface_depth_multiplier)??0,M.readBoolean(f.add_surface_depth)??!1);case"y_above":return new u(Vt.fromJson(f.anchor),M.readInt(f.surface_depth_multiplier)??0,M.readBoolean(f.add_surface_depth)??!1)}return n.ALWAYS_FALSE}n.fromJson=t;function e(d,f){let p=d.lastUpdateY-1,m=!1;return()=>(d.lastUpdateY!==p&&(p=d.lastUpdateY,m=f()),m)}class i extends n{holder;constructor(f){super(),this.holder=f}compile(f){return this.holder.value().compile(f)}}n.HolderHolder=i;class r extends n{compile(f){return()=>f.blockY>=f.getMinSurfaceLevel()}}n.AbovePreliminarySurface=r;class s extends n{biomes;constructor(f){super(),this.biomes=f}compile(f){let p=new Set(Array(...this.biomes.value().getEntries()).map(m=>m.key().toString()));return e(f,()=>p.has(f.getBiome().toString()))}}n.Biome=s;class a extends n{noise;minThreshold;maxThreshold;is3d;constructor(f,p,m,g){super(),this.noise=f,this.minThreshold=p,this.maxThreshold=m,this.is3d=g}compile(f){let p=f.getNoiseSampler(this.noise,this.is3d);return()=>{let m=p();return this.minThreshold<=m&&m<=this.maxThreshold}}}n.NoiseThreshold=a;class o extends n{invert;constructor(f){super(),this.invert=f}compile(f){let p=this.invert.compile(f);return()=>!p()}}n.Not=o;class h extends n{offset;addSurfaceDepth;secondaryDepthRange;ceiling;constructor(f,p,m,g){super(),this.offset=f,this.addSurfaceDepth=p,this.secondaryDepthRange=m,this.ceiling=g}compile(f){return e(f,()=>{let p=this.ceiling?f.stoneDepthBelow:f.stoneDepthAbove,m=this.addSurfaceDepth?f.surfaceDepth:0,g=this.secondaryDepthRange===0?0:ys(f.getSurfaceSecondary(),-1,1,0,this.secondaryDepthRange);return p<=1+this.offset+m+g})}}n.StoneDepth=h;class l extends n{randomName;trueAtAndBelow;falseAtAndAbove;constructor(f,p,m){super(),this.randomName=f,this.trueAtAndBelow=p,this.falseAtAndAbove=m}compile(f){let p=f.resolveAnchorY(this.trueAtAndBelow),m=f.resolveAnchorY(this.falseAtAndAbove),g=f.system.getOrCreateRandom(this.randomName);return e(f,()=>{if(f.blockY<=p)return!0;if(f.blockY>=m)return!1;let _=ys(f.blockY,p,m,1,0);return g.at(f.blockX,f.blockY,f.blockZ).nextFloat()<_})}}n.VerticalGradient=l;class c extends n{offset;surfaceDepthMultiplier;addStoneDepth;constructor(f,p,m){super(),this.offset=f,this.surfaceDepthMultiplier=p,this.addStoneDepth=m}compile(f){return e(f,()=>{if(f.waterHeight===Number.MIN_SAFE_INTEGER)return!0;let p=this.addStoneDepth?f.stoneDepthAbove:0;return f.blockY+p>=f.waterHeight+this.offset+f.surfaceDepth*this.surfaceDepthMultiplier})}}n.Water=c;class u extends n{anchor;surfaceDepthMultiplier;addStoneDepth;constructor(f,p,m){super(),this.anchor=f,this.surfaceDepthMultiplier=p,this.addStoneDepth=m}compile(f){return e(f,()=>{let p=this.addStoneDepth?f.stoneDepthAbove:0;return f.blockY+p>=f.resolveAnchorY(this.anchor)+f.surfaceDepth*this.surfaceDepthMultiplier})}}n.YAbove=u})(Sn=Sn||(Sn={}));var Wn;(function(n){let t=s=>new vt.HolderHolder(lt.parser(qt.DENSITY_FUNCTION,vt.fromJson)(s));function e(s){let a=M.readObject(s)??{};return{temperature:t(a.temperature),vegetation:t(a.vegetation),continents:t(a.continents),erosion:t(a.erosion),depth:t(a.depth),ridges:t(a.ridges),chunkSurfaceLevel:t(a.preliminary_surface_level),finalDensity:t(a.final_density)}}n.fromJson=e;function i(s){return{temperature:vt.Constant.ZERO,vegetation:vt.Constant.ZERO,continents:vt.Constant.ZERO,erosion:vt.Constant.ZERO,depth:vt.Constant.ZERO,ridges:vt.Constant.ZERO,chunkSurfaceLevel:vt.Constant.ZERO,finalDensity:vt.Constant.ZERO,...s}}n.create=i;function r(s,a){return{temperature:s.temperature.mapAll(a),vegetation:s.vegetation.mapAll(a),continents:s.continents.mapAll(a),erosion:s.erosion.mapAll(a),depth:s.depth.mapAll(a),ridges:s.ridges.mapAll(a),chunkSurfaceLevel:s.chunkSurfaceLevel.mapAll(a),finalDensity:s.finalDensity.mapAll(a)}}n.mapAll=r})(Wn=Wn||(Wn={}));var Ti;(function(n){function t(i){let r=M.readObject(i)??{};return{minY:M.readInt(r.min_y)??0,height:M.readInt(r.height)??256}}n.fromJson=t;function e(i){return{minY:0,height:256,...i}}n.create=e})(Ti=Ti||(Ti={}));var Sr;(function(n){function t(i){let r=M.readObject(i)??{};return{noise:Ti.fromJson(r.noise),defaultBlock:Tt.fromJson(r.default_block),defaultFluid:Tt.fromJson(r.default_fluid),noiseRouter:Wn.fromJson(r.noise_router),materialRule:We.fromJson(r.material_rule),seaLevel:M.readInt(r.sea_level)??0,aquifers:r.aquifers?Mr.fromJson(r.aquifers):void 0,legacyRandomSource:M.readBoolean(r.legacy_random_source)??!1}}n.fromJson=t;function e(i){return{noise:Ti.create({}),defaultBlock:Tt.STONE,defaultFluid:Tt.WATER,noiseRouter:Wn.create({}),materialRule:We.NOOP,seaLevel:0,aquifers:void 0,legacyRandomSource:!1,...i}}n.create=e})(Sr=Sr||(Sr={}));var qt=class n{static NOISE=Gt.createAndRegister("worldgen/noise",An.fromJson);static DENSITY_FUNCTION=Gt.createAndRegister("worldgen/density_function",t=>vt.fromJson(t));static NOISE_SETTINGS=Gt.createAndRegister("worldgen/noise_settings",Sr.fromJson);static MATERIAL_RULE=Gt.createAndRegister("worldgen/material_rule",We.fromJson);static MATERIAL_CONDITION=Gt.createAndRegister("worldgen/material_condition",Sn.fromJson);static BIOME=Gt.createAndRegister("worldgen/biome");static SURFACE_NOISE=n.createNoise("surface",.9381732587751008,-6,[1,1,1]);static SURFACE_SECONDARY_NOISE=n.createNoise("surface_secondary",1.0582769165096106,-6,[1,1,0,1]);static createNoise(t,e,i,r){return n.NOISE.register(T.create(t),new An(e,i,r.length,"enabled",r),!0)}};var vt=class{computeVolume(t){let e=0,i=Array(t.size());for(let r=0;r<t.sizeZ;r+=1){let s=t.blockZ(r);for(let a=0;a<t.sizeX;a+=1){let o=t.blockX(a);for(let h=0;h<t.sizeY;h+=1){let l=t.blockY(h);i[e]=this.compute({x:o,y:l,z:s}),e+=1}}}return i}mapAll(t){return{apply(i){return t.apply(i.mapChildren(this))}}.apply(this)}};(function(n){function t(j,S,E){return{x:j,y:S,z:E}}n.context=t;class e extends n{input;constructor(S){super(),this.input=S}compute(S){return this.transform(S,this.input.compute(S))}}let i=lt.parser(qt.NOISE,An.fromJson),r=j=>{let S=M.readArray(j,E=>M.readNumber(E)??0)??[];return new Bt(S[0]??0,S[1]??0,S[2]??0)};function s(j,S=s){if(typeof j=="string")return new o(lt.reference(qt.DENSITY_FUNCTION,T.parse(j)));if(typeof j=="number")return new a(j);let E=M.readObject(j)??{},D=M.readString(E.type)?.replace(/^minecraft:/,"");switch(D){case"blend_alpha":return new h(1,0,1);case"blend_offset":return new h(0,-1/0,1/0);case"beardifier":return new h(0,-1/0,1/0);case"old_blended_noise":return new l(M.readNumber(E.xz_scale)??1,M.readNumber(E.y_scale)??1,M.readNumber(E.xz_factor)??80,M.readNumber(E.y_factor)??160,M.readNumber(E.smear_scale_multiplier)??8);case"interpolated":return new u(S(E.input??E.argument),M.readInt(E.cell_size_xz)??4,M.readInt(E.cell_size_y)??4);case"cache":return new c(S(E.input??E.argument));case"noise":return new d(i(E.noise),M.readNumber(E.xz_scale)??1,M.readNumber(E.y_scale)??1,E.shift_x?S(E.shift_x):n.Constant.ZERO,E.shift_y?S(E.shift_y):n.Constant.ZERO,E.shift_z?S(E.shift_z):n.Constant.ZERO);case"end_outer_islands":return new f;case"find_top_surface":return new p(S(E.density),S(E.upper_bound),M.readInt(E.lower_bound)??0,M.readInt(E.cell_height)??1);case"range_choice":return new m(S(E.input),M.readNumber(E.min_inclusive)??0,M.readNumber(E.max_exclusive)??1,S(E.when_in_range),S(E.when_out_of_range));case"shift_a":return new _(i(E.noise??E.argument));case"shift_b":return new y(i(E.noise??E.argument));case"shift":return new v(i(E.noise??E.argument));case"blend_density":return new x(S(E.input??E.argument));case"clamp":return new w(S(E.input),M.readNumber(E.min)??0,M.readNumber(E.max)??1);case"interval_select":return new b(S(E.input),M.readArray(E.thresholds,Y=>M.readNumber(Y)??0)??[],M.readArray(E.functions,S)??[]);case"abs":case"square":case"cube":case"sqrt":case"half_negative":case"quarter_negative":case"squeeze":case"reciprocal":case"negate":case"log":case"sign":return new I(D,S(E.input??E.argument));case"add":case"sub":case"mul":case"div":case"min":case"max":return new P(M.readEnum(D,C),S(E.left??E.argument1),S(E.right??E.argument2));case"spline":return new q(Qi.fromJson(E.spline,S));case"constant":return new a(M.readNumber(E.value??E.argument)??0);case"gradient":return new pt(M.readEnum(E.axis,V),M.readEnum(E.tiling,B),M.readInt(E.from_coordinate)??0,M.readInt(E.to_coordinate)??1,M.readNumber(E.from_value)??0,M.readNumber(E.to_value)??1);case"lerp":return new at(S(E.alpha),S(E.first),S(E.second));case"floor":case"round":case"ceil":case"truncate":return new O(D,S(E.input),S(E.multiple));case"pow":return new H(S(E.base),S(E.exponent));case"distance_to_point":return new Q(r(E.point),M.readEnum(E.metric,gt));case"slice":return new Rt(M.readEnum(E.axis,V),M.readInt(E.coordinate)??0,S(E.input))}return a.ZERO}n.fromJson=s;class a extends n{value;static ZERO=new a(0);static ONE=new a(1);constructor(S){super(),this.value=S}compute(){return this.value}mapChildren(S){return this}range(){return X.ofExact(this.value)}}n.Constant=a;class o extends n{holder;constructor(S){super(),this.holder=S}compute(S){return this.holder.value().compute(S)}mapChildren(S){return new o(lt.direct(S.apply(this.holder.value())))}range(){return this.holder.value().range()}}n.HolderHolder=o;class h extends n.Constant{min;max;constructor(S,E,D){super(S),this.min=E,this.max=D}range(){return X.of(this.min,this.max)}}n.ConstantMinMax=h;class l extends n{xzScale;yScale;xzFactor;yFactor;smearScaleMultiplier;blendedNoise;constructor(S,E,D,Y,_t,Yt){super(),this.xzScale=S,this.yScale=E,this.xzFactor=D,this.yFactor=Y,this.smearScaleMultiplier=_t,this.blendedNoise=Yt}compute(S){return this.blendedNoise?.sample(S.x,S.y,S.z)??0}mapChildren(S){return this}range(){return this.blendedNoise?this.blendedNoise.range():X.INFINITE}}n.OldBlendedNoise=l;class c extends n{input;constructor(S){super(),this.input=S}compute(S){return this.input.compute(S)}mapChildren(S){return new c(S.apply(this.input))}range(){return this.input.range()}}n.Cache=c;class u extends n{input;cellSizeXz;cellSizeY;values;constructor(S,E,D){super(),this.input=S,this.cellSizeXz=E,this.cellSizeY=D,this.values=new Map}compute({x:S,y:E,z:D}){let Y=this.cellSizeXz,_t=this.cellSizeY,Yt=(S%Y+Y)%Y/Y,Pt=(E%_t+_t)%_t/_t,Nt=(D%Y+Y)%Y/Y,Ct=Math.floor(S/Y)*Y,ut=Math.floor(E/_t)*_t,W=Math.floor(D/Y)*Y;return fh(Yt,Pt,Nt,()=>this.computeCorner(Ct,ut,W),()=>this.computeCorner(Ct+Y,ut,W),()=>this.computeCorner(Ct,ut+_t,W),()=>this.computeCorner(Ct+Y,ut+_t,W),()=>this.computeCorner(Ct,ut,W+Y),()=>this.computeCorner(Ct+Y,ut,W+Y),()=>this.computeCorner(Ct,ut+_t,W+Y),()=>this.computeCorner(Ct+Y,ut+_t,W+Y))}computeCorner(S,E,D){return Ki(this.values,`${S} ${E} ${D}`,()=>this.input.compute(n.context(S,E,D)))}mapChildren(S){return new u(S.apply(this.input),this.cellSizeXz,this.cellSizeY)}range(){return this.input.range()}}n.Interpolated=u;class d extends n{noise;xzScale;yScale;shiftX;shiftY;shiftZ;noiseSampler;constructor(S,E,D,Y,_t,Yt,Pt){super(),this.noise=S,this.xzScale=E,this.yScale=D,this.shiftX=Y,this.shiftY=_t,this.shiftZ=Yt,this.noiseSampler=Pt}compute(S){let E=S.x*this.xzScale+this.shiftX.compute(S),D=S.y*this.yScale+this.shiftY.compute(S),Y=S.z*this.xzScale+this.shiftZ.compute(S);return this.noiseSampler?.get3D(E,D,Y)??0}mapChildren(S){return new d(this.noise,this.xzScale,this.yScale,S.apply(this.shiftX),S.apply(this.shiftY),S.apply(this.shiftZ),this.noiseSampler)}range(){return this.noiseSampler?this.noiseSampler.range():X.INFINITE}}n.NoiseFunction=d;class f extends n{islandNoise;constructor(S){super();let E=new zt(S??BigInt(0));E.consume(17292),this.islandNoise=new Es(E)}getHeightValue(S,E){let D=Math.floor(S/2),Y=Math.floor(E/2),_t=S%2,Yt=E%2,Pt=Ot(100-Math.sqrt(S*S+E*E)*8,-100,80);for(let Nt=-12;Nt<=12;Nt+=1)for(let Ct=-12;Ct<=12;Ct+=1){let ut=D+Nt,W=Y+Ct;if(ut*ut+W*W<=4096||this.islandNoise.get2D(ut,W)>=-.9)continue;let F=(Math.abs(ut)*3439+Math.abs(W)*147)%13+9,it=_t+Nt*2,be=Yt+Ct*2,Pe=100-Math.sqrt(it*it+be*be)*F,Ne=Ot(Pe,-100,80);Pt=Math.max(Pt,Ne)}return Pt}compute({x:S,y:E,z:D}){return(this.getHeightValue(Math.floor(S/8),Math.floor(D/8))-8)/128}mapChildren(S){return this}range(){return X.of(-.84375,.5625)}}n.EndOuterIslands=f;class p extends n{density;upperBound;lowerBound;cellHeight;constructor(S,E,D,Y){super(),this.density=S,this.upperBound=E,this.lowerBound=D,this.cellHeight=Y}compute(S){let E=Math.floor(this.upperBound.compute(S)/this.cellHeight)*this.cellHeight;if(E<this.lowerBound)return this.lowerBound;for(let D=E;D>=this.lowerBound;D-=this.cellHeight)if(this.density.compute(n.context(S.x,D,S.z))>0)return D;return this.lowerBound}mapChildren(S){return new p(S.apply(this.density),S.apply(this.upperBound),this.lowerBound,this.cellHeight)}range(){return X.of(this.lowerBound,Math.max(this.lowerBound,this.upperBound.range().max))}}n.FindTopSurface=p;class m extends n{input;minInclusive;maxExclusive;whenInRange;whenOutOfRange;constructor(S,E,D,Y,_t){super(),this.input=S,this.minInclusive=E,this.maxExclusive=D,this.whenInRange=Y,this.whenOutOfRange=_t}compute(S){let E=this.input.compute(S);return this.minInclusive<=E&&E<this.maxExclusive?this.whenInRange.compute(S):this.whenOutOfRange.compute(S)}mapChildren(S){return new m(S.apply(this.input),this.minInclusive,this.maxExclusive,S.apply(this.whenInRange),S.apply(this.whenOutOfRange))}range(){return X.encapsulating(this.whenInRange.range(),this.whenOutOfRange.range())}}n.RangeChoice=m;class g extends n{noise;noiseSampler;constructor(S,E){super(),this.noise=S,this.noiseSampler=E}compute(S){return(this.noiseSampler?.get3D(S.x*.25,S.y*.25,S.z*.25)??0)*4}mapChildren(S){return this}range(){return this.noiseSampler?X.mul(this.noiseSampler.range(),X.ofExact(4)):X.INFINITE}}n.ShiftNoise=g;class _ extends g{constructor(S,E){super(S,E)}compute(S){return super.compute(n.context(S.x,0,S.z))}withNewNoise(S){return new _(this.noise,S)}}n.ShiftA=_;class y extends g{constructor(S,E){super(S,E)}compute(S){return super.compute(n.context(S.z,S.x,0))}withNewNoise(S){return new y(this.noise,S)}}n.ShiftB=y;class v extends g{constructor(S,E){super(S,E)}withNewNoise(S){return new v(this.noise,S)}}n.Shift=v;class x extends e{constructor(S){super(S)}transform(S,E){return E}mapChildren(S){return new x(S.apply(this.input))}range(){return X.INFINITE}}n.BlendDensity=x;class w extends e{min;max;constructor(S,E,D){super(S),this.min=E,this.max=D}transform(S,E){return Ot(E,this.min,this.max)}mapChildren(S){return new w(S.apply(this.input),this.min,this.max)}range(){return X.clamp(this.input.range(),this.min,this.max)}}n.Clamp=w;class b extends n{input;thresholds;functions;constructor(S,E,D){super(),this.input=S,this.thresholds=E,this.functions=D;let Y=Math.min(E.length,D.length);this.thresholds=this.thresholds.slice(0,Y),this.functions=this.functions.slice(0,Y)}compute(S){let E=this.input.compute(S);for(let D=0;D<this.thresholds.length;D+=1)if(E<this.thresholds[D])return this.functions[D].compute(S);return this.functions[this.functions.length-1].compute(S)}mapChildren(S){return new b(S.apply(this.input),this.thresholds,this.functions.map(E=>S.apply(E)))}range(){return X.encapsulating(...this.functions.map(S=>S.range()))}}n.IntervalSelect=b;let A=["abs","square","cube","sqrt","half_negative","quarter_negative","squeeze","reciprocal","negate","log","sign"];class I extends e{type;constructor(S,E){super(E),this.type=S}transform(S,E){return I.transform(this.type,E)}static transform(S,E){switch(S){case"abs":return Math.abs(E);case"square":return E*E;case"cube":return E*E*E;case"half_negative":return E>0?E:E*.5;case"quarter_negative":return E>0?E:E*.25;case"squeeze":let D=Ot(E,-1,1);return D/2-D*D*D/24;case"reciprocal":return 1/E;case"negate":return-E;case"sqrt":return Math.sqrt(E);case"log":return Math.log(E);case"sign":return Math.sign(E)}}mapChildren(S){return new I(this.type,S.apply(this.input))}range(){let S=this.input.range();switch(this.type){case"abs":return X.abs(S);case"square":return X.square(S);case"cube":case"half_negative":case"quarter_negative":case"squeeze":return X.mapMonotonic(S,E=>I.transform(this.type,E));case"reciprocal":return X.reciprocal(S);case"negate":return X.sub(X.ofExact(0),S);case"sqrt":return X.pow(S,X.ofExact(.5));case"log":return X.log(S);case"sign":return X.sign(S)}}}n.Unary=I;let C=["add","sub","mul","div","min","max"];class P extends n{type;left;right;rightRange=X.INFINITE;constructor(S,E,D){super(),this.type=S,this.left=E,this.right=D}compute(S){let E=this.left.compute(S);switch(this.type){case"add":return E+this.right.compute(S);case"sub":return E-this.right.compute(S);case"mul":return E===0?0:E*this.right.compute(S);case"div":return E===0?0:E/this.right.compute(S);case"min":return E<this.rightRange.min?E:Math.min(E,this.right.compute(S));case"max":return E>this.rightRange.max?E:Math.max(E,this.right.compute(S))}}mapChildren(S){return new P(this.type,S.apply(this.left),S.apply(this.right))}range(){let S=this.left.range(),E=this.right.range();switch(this.type){case"add":return X.add(S,E);case"sub":return X.sub(S,E);case"mul":return X.mul(S,E);case"div":return X.div(S,E);case"min":return X.min(S,E);case"max":return X.max(S,E)}}trySimplify(){if(this.type==="mul"||this.type==="add"){if(this.left instanceof a)return new G(this.type,this.right,this.left.value);if(this.right instanceof a)return new G(this.type,this.left,this.right.value)}return this.rightRange=this.right.range(),this}}n.Binary=P;let L=["add","mul"];class G extends e{type;value;constructor(S,E,D){super(E),this.type=S,this.value=D}transform(S,E){switch(this.type){case"mul":return E*this.value;case"add":return E+this.value}}mapChildren(S){return new G(this.type,S.apply(this.input),this.value)}range(){switch(this.type){case"mul":return X.mul(this.input.range(),X.ofExact(this.value));case"add":return X.add(this.input.range(),X.ofExact(this.value))}}}n.MulOrAdd=G;class q extends n{spline;constructor(S){super(),this.spline=S}compute(S){return this.spline.compute(S)}mapChildren(S){return new q(this.spline.mapCoordinates(E=>E instanceof n?S.apply(E):E))}range(){return this.spline.range()}}n.Spline=q;let V=["x","y","z"],B=["clamp_to_edge","repeat","mirrored_repeat"];class pt extends n{axis;tiling;fromCoordinate;toCoordinate;fromValue;toValue;constructor(S,E,D,Y,_t,Yt){super(),this.axis=S,this.tiling=E,this.fromCoordinate=D,this.toCoordinate=Y,this.fromValue=_t,this.toValue=Yt}compute(S){let E=this.toCoordinate-this.fromCoordinate,D=S[this.axis]-this.fromCoordinate;switch(this.tiling){case"clamp_to_edge":break;case"repeat":D=(D%E+E)%E;break;case"mirrored_repeat":let Y=Math.floor(D/E),_t=D-Y*E;D=(Y&1)==0?_t:E-_t;break}return dh(D/E,this.fromValue,this.toValue)}mapChildren(S){return this}range(){return X.between(this.fromValue,this.toValue)}}n.Gradient=pt;class at extends n{alpha;first;second;constructor(S,E,D){super(),this.alpha=S,this.first=E,this.second=D}compute(S){let E=this.alpha.compute(S);return E===0?this.first.compute(S):E===1?this.second.compute(S):di(E,this.first.compute(S),this.second.compute(S))}mapChildren(S){return new at(S.apply(this.alpha),S.apply(this.first),S.apply(this.second))}range(){return X.lerp(this.alpha.range(),this.first.range(),this.second.range())}}n.Lerp=at;let N=["floor","round","ceil","truncate"];class O extends n{type;input;multiple;constructor(S,E,D){super(),this.type=S,this.input=E,this.multiple=D}compute(S){let E=this.input.compute(S),D=this.multiple.compute(S);return D===0?E:this.roundToInteger(E/D)*D}roundToInteger(S){switch(this.type){case"floor":return Math.floor(S);case"round":return Math.round(S);case"ceil":return Math.ceil(S);case"truncate":return Math.trunc(S)}}mapChildren(S){return new O(this.type,S.apply(this.input),S.apply(this.multiple))}range(){let S=this.multiple.range();return X.mul(X.mapMonotonic(X.div(this.input.range(),S),E=>this.roundToInteger(E)),S)}}n.Round=O;class H extends n{base;exponent;constructor(S,E){super(),this.base=S,this.exponent=E}compute(S){return Math.pow(this.base.compute(S),this.exponent.compute(S))}mapChildren(S){return new H(S.apply(this.base),S.apply(this.exponent))}range(){return X.pow(this.base.range(),this.exponent.range())}}n.Pow=H;let gt=["euclidean","euclidean_squared","manhattan","chebyshev"];class Q extends n{point;metric;constructor(S,E){super(),this.point=S,this.metric=E}compute(S){let E=this.point.sub(new Bt(S.x,S.y,S.z));switch(this.metric){case"euclidean":return E.length();case"euclidean_squared":return E.lengthSquared();case"manhattan":return Math.abs(E.x)+Math.abs(E.y)+Math.abs(E.z);case"chebyshev":return Math.max(Math.abs(E.x),Math.abs(E.y),Math.abs(E.z))}}mapChildren(S){return this}range(){return X.of(0,1/0)}}n.DistanceToPoint=Q;class Rt extends n{axis;coordinate;input;constructor(S,E,D){super(),this.axis=S,this.coordinate=E,this.input=D}compute(S){switch(this.axis){case"x":return this.input.compute({x:0,y:S.y,z:S.z});case"y":return this.input.compute({x:0,y:S.y,z:S.z});case"z":return this.input.compute({x:0,y:S.y,z:S.z})}}mapChildren(S){return new Rt(this.axis,this.coordinate,S.apply(this.input))}range(){return this.input.range()}}n.Slice=Rt})(vt=vt||(vt={}));var Mr;(function(n){let t=r=>new vt.HolderHolder(lt.parser(qt.DENSITY_FUNCTION,vt.fromJson)(r));function e(r){let s=M.readObject(r)??{};return{barrier:t(s.barrier),fluidLevelFloodedness:t(s.fluid_level_floodedness),fluidLevelSpread:t(s.fluid_level_spread),lava:t(s.lava),exclusion:t(s.exclusion),surfaceLevel:t(s.surface_level)}}n.fromJson=e;function i(r,s){return{barrier:r.barrier.mapAll(s),fluidLevelFloodedness:r.fluidLevelFloodedness.mapAll(s),fluidLevelSpread:r.fluidLevelSpread.mapAll(s),lava:r.lava.mapAll(s),exclusion:r.exclusion.mapAll(s),surfaceLevel:r.surfaceLevel.mapAll(s)}}n.mapAll=i})(Mr=Mr||(Mr={}));var qs;(function(n){function t(e){return{computeSubstance(i,r,s,a){if(!(a>0))return e(i,r,s).at(r)}}}n.createDisabled=t})(qs=qs||(qs={}));var Ys=class n{shift;biomes;n;constructor(t,e){if(this.shift=t,this.biomes=e,e.length===0)throw new Error("Cannot create checkerboard biome source without biomes");this.n=e.length}getBiome(t,e,i){let r=(((t>>this.shift)+(i>>this.shift))%this.n+this.n)%this.n;return T.parse(this.biomes[r].toString())}static fromJson(t){let e=M.readObject(t)??{},i=M.readInt(e.scale)??2,r;return typeof e.biomes=="string"?r=[T.parse(e.biomes)]:r=M.readArray(e.biomes,s=>T.parse(M.readString(s)??""))??[],new n(i+2,r)}};var Ri=class n{biome;constructor(t){this.biome=t}getBiome(){return this.biome}static fromJson(t){let e=M.readObject(t)??{},i=T.parse(M.readString(e.biome)??"plains");return new n(i)}};var Xn;(function(n){function e(p,m,g,_,y,v){return new o(p,m,g,_,y,v)}n.target=e;function i(p,m,g,_,y,v,x){return new a(r(p),r(m),r(g),r(_),r(y),r(v),x)}n.parameters=i;function r(p,m){return typeof p=="number"?new s(p,m??p):p}n.param=r;class s{min;max;constructor(m,g){this.min=m,this.max=g}distance(m){let g=(typeof m=="number"?m:m.min)-this.max,_=this.min-(typeof m=="number"?m:m.max);return g>0?g:Math.max(_,0)}union(m){return new s(Math.min(this.min,m.min),Math.max(this.max,m.max))}static fromJson(m){if(typeof m=="number")return new s(m,m);let[g,_]=M.readArray(m,y=>M.readNumber(y))??[];return new s(g??0,_??0)}}n.Param=s;class a{temperature;humidity;continentalness;erosion;depth;weirdness;offset;constructor(m,g,_,y,v,x,w){this.temperature=m,this.humidity=g,this.continentalness=_,this.erosion=y,this.depth=v,this.weirdness=x,this.offset=w}fittness(m){return Re(this.temperature.distance(m.temperature))+Re(this.humidity.distance(m.humidity))+Re(this.continentalness.distance(m.continentalness))+Re(this.erosion.distance(m.erosion))+Re(this.depth.distance(m.depth))+Re(this.weirdness.distance(m.weirdness))+Re(this.offset-m.offset)}space(){return[this.temperature,this.humidity,this.continentalness,this.erosion,this.depth,this.weirdness,new s(this.offset,this.offset)]}static fromJson(m){let g=M.readObject(m)??{};return new a(s.fromJson(g.temperature),s.fromJson(g.humidity),s.fromJson(g.continentalness),s.fromJson(g.erosion),s.fromJson(g.depth),s.fromJson(g.weirdness),M.readNumber(g.offset)??0)}}n.ParamPoint=a;class o{temperature;humidity;continentalness;erosion;depth;weirdness;constructor(m,g,_,y,v,x){this.temperature=m,this.humidity=g,this.continentalness=_,this.erosion=y,this.depth=v,this.weirdness=x}get offset(){return 0}toArray(){return[this.temperature,this.humidity,this.continentalness,this.erosion,this.depth,this.weirdness,this.offset]}}n.TargetPoint=o;class h{things;index;constructor(m){this.things=m,this.index=new c(m)}find(m){return this.index.search(m,(g,_)=>g.distance(_))}}n.Parameters=h;class l{temperature;humidity;continentalness;erosion;depth;weirdness;constructor(m,g,_,y,v,x){this.temperature=m,this.humidity=g,this.continentalness=_,this.erosion=y,this.depth=v,this.weirdness=x}static fromRouter(m){return new n.Sampler(m.temperature,m.vegetation,m.continents,m.erosion,m.depth,m.ridges)}sample(m,g,_){let y=vt.context(m<<2,g<<2,_<<2);return n.target(this.temperature.compute(y),this.humidity.compute(y),this.continentalness.compute(y),this.erosion.compute(y),this.depth.compute(y),this.weirdness.compute(y))}}n.Sampler=l;class c{static CHILDREN_PER_NODE=10;root;last_leaf=null;constructor(m){if(m.length===0)throw new Error("At least one point is required to build search tree");this.root=c.build(m.map(([g,_])=>new f(g,_)))}static build(m){if(m.length===1)return m[0];if(m.length<=c.CHILDREN_PER_NODE){let v=m.map(x=>{let w=0;for(let b=0;b<7;b+=1){let A=x.space[b];w+=Math.abs((A.min+A.max)/2)}return{key:w,node:x}}).sort((x,w)=>x.key-w.key).map(({node:x})=>x);return new d(v)}let g=1/0,_=-1,y=[];for(let v=0;v<7;++v){m=c.sort(m,v,!1),y=c.bucketize(m);let x=0;for(let w of y)x+=c.area(w.space);g>x&&(g=x,_=v)}return m=c.sort(m,_,!1),y=c.bucketize(m),y=c.sort(y,_,!0),new d(y.map(v=>c.build(v.children)))}static sort(m,g,_){return m.map(y=>{let v=y.space[g],x=(v.min+v.max)/2;return{key:_?Math.abs(x):x,node:y}}).sort((y,v)=>y.key-v.key).map(({node:y})=>y)}static bucketize(m){let g=[],_=[],y=Math.pow(10,Math.floor(Math.log(m.length-.01)/Math.log(10)));for(let v of m)_.push(v),!(_.length<y)&&(g.push(new d(_)),_=[]);return _.length!==0&&g.push(new d(_)),g}static area(m){let g=0;for(let _ of m)g+=Math.abs(_.max-_.min);return g}search(m,g){let _=this.root.search(m.toArray(),this.last_leaf,g);return this.last_leaf=_,_.thing()}}n.RTree=c;class u{space;constructor(m){this.space=m}distance(m){let g=0;for(let _=0;_<7;_+=1)g+=Re(this.space[_].distance(m[_]));return g}}n.RNode=u;class d extends u{children;constructor(m){super(d.buildSpace(m)),this.children=m}static buildSpace(m){let g=[...Array(7)].map(()=>new s(1/0,-1/0));for(let _ of m)g=[...Array(7)].map((y,v)=>g[v].union(_.space[v]));return g}search(m,g,_){let y=g?_(g,m):1/0,v=g;for(let x of this.children){let w=_(x,m);if(y<=w)continue;let b=x.search(m,v,_);if(b===null)continue;let A=x==b?w:_(b,m);if(A===0)return b;y<=A||(y=A,v=b)}return v}}n.RSubTree=d;class f extends u{thing;constructor(m,g){super(m.space()),this.thing=g}search(){return this}}n.RLeaf=f})(Xn=Xn||(Xn={}));var Zs=class n{parameters;constructor(t){this.parameters=new Xn.Parameters(t)}getBiome(t,e,i,r){let s=r.sample(t,e,i);return this.parameters.find(s)}static fromJson(t){let e=M.readObject(t)??{},r=(M.readArray(e.biomes,s=>(a=>({biome:T.parse(M.readString(a.biome)??"plains"),parameters:Xn.ParamPoint.fromJson(a.parameters)}))(M.readObject(s)??{}))??[]).map(s=>[s.parameters,()=>s.biome]);return new n(r)}};var Js=class n{static END=T.create("the_end");static HIGHLANDS=T.create("end_highlands");static MIDLANDS=T.create("end_midlands");static ISLANDS=T.create("small_end_islands");static BARRENS=T.create("end_barrens");getBiome(t,e,i,r){let s=t<<2,a=e<<2,o=i<<2,h=s>>4,l=o>>4;if(h*h+l*l<=4096)return n.END;let c=vt.context((h*2+1)*8,a,(l*2+1)*8),u=r.erosion.compute(c);return u>.25?n.HIGHLANDS:u>=-.0625?n.MIDLANDS:u>=-.21875?n.BARRENS:n.ISLANDS}static fromJson(t){return new n}};var br;(function(n){function t(i){let r=M.readObject(i)??{};switch(M.readString(r.type)?.replace(/^minecraft:/,"")){case"fixed":return Ri.fromJson(i);case"checkerboard":return Ys.fromJson(i);case"multi_noise":return Zs.fromJson(i);case"the_end":return Js.fromJson(i);default:return new Ri(T.create("plains"))}}n.fromJson=t;function e(i,r,s,a,o,h,l,c,u=1,d=!1){if(i instanceof Ri)return h(i.getBiome())?d?{pos:ot.create(r,s,a),biome:i.getBiome()}:{pos:ot.create(r-o+l.nextInt(o*2+1),s,a-o+l.nextInt(o*2+1)),biome:i.getBiome()}:void 0;let f=r>>2,p=a>>2,m=o>>2,g=s>>2;for(var _=void 0,y=0,v=d?0:m,x=v;x<=m;x+=u)for(var w=-x;w<=x;w+=u){let A=Math.abs(w)===x;for(var b=-x;b<=x;b+=u){if(d&&!(Math.abs(b)===x)&&!A)continue;let I=f+b,C=p+w,P=i.getBiome(I,g,C,c);if(h(P)){if((_===void 0||l.nextInt(y+1)<=.5)&&(_={pos:ot.create(I<<2,s,C<<2),biome:P},d))return _;y++}}}return _}n.findBiomeHorizontal=e})(br=br||(br={}));var wr;(function(n){function t(e){if(typeof e=="string"&&(e==="WORLD_SURFACE_WG"||e==="WORLD_SURFACE"||e==="OCEAN_FLOOR_WG"||e==="OCEAN_FLOOR"||e==="MOTION_BLOCKING"||e==="MOTION_BLOCKING_NO_LEAVES"))return e}n.fromJson=t})(wr=wr||(wr={}));var Er;(function(n){function t(h){let l=M.readObject(h)??{};switch(M.readString(l.type)?.replace(/^minecraft:/,"")){case void 0:return e(Vt.fromJson(h));case"constant":return e(Vt.fromJson(l.value));case"uniform":return i(Vt.fromJson(l.min_inclusive),Vt.fromJson(l.max_inclusive));case"biased_to_bottom":return r(Vt.fromJson(l.min_inclusive),Vt.fromJson(l.max_inclusive),M.readInt(l.inner));case"very_biased_to_bottom":return s(Vt.fromJson(l.min_inclusive),Vt.fromJson(l.max_inclusive),M.readInt(l.inner));case"trapezoid":return a(Vt.fromJson(l.min_inclusive),Vt.fromJson(l.max_inclusive),M.readInt(l.plateau));case"weighted_list":return o(M.readArray(l.distribution,u=>{let d=M.readObject(u)??{};return{weight:M.readInt(d.weight)??1,data:t(d.data)}})??[])}return()=>0}n.fromJson=t;function e(h){return(l,c)=>h(c)}n.constant=e;function i(h,l){return(c,u)=>{let d=h(u),f=l(u);return d>f?d:c.nextInt(f-d+1)+d}}n.uniform=i;function r(h,l,c=1){return(u,d)=>{let f=h(d),p=l(d);if(p-f-c+1<=0)return f;{let m=u.nextInt(p-f-c+1);return u.nextInt(m+c)+f}}}n.biased_to_bottom=r;function s(h,l,c=1){return(u,d)=>{let f=h(d),p=l(d);if(p-f-c+1<=0)return f;{let m=bs(u,f+c,p),g=bs(u,f,m-1);return bs(u,f,g-1+c)}}}n.very_biased_to_bottom=s;function a(h,l,c=0){return(u,d)=>{let f=h(d),p=l(d);if(f>p)return f;{let m=p-f;if(c>=m)return Ms(u,f,p);{let g=(m-c)/2,_=m-g;return f+Ms(u,0,_)+Ms(u,0,g)}}}}n.trapezoid=a;function o(h){let l=h.reduce((c,u,d)=>c+u.weight,0);return(c,u)=>{let d=c.nextInt(l);for(let f of h)if(d-=f.weight,d<=0)return f.data(c,u);return 0}}n.weighted_list=o})(Er=Er||(Er={}));var je=class n{static fromJson(t){let e=M.readObject(t)??{};switch(M.readString(e.element_type)?.replace(/^minecraft:/,"")){case"single_pool_element":case"legacy_single_pool_element":let i=T.parse(M.readString(e.location)??""),r={key:()=>i,value:()=>Hn.REGISTRY.get(i)??Hn.EMPTY};return new n.SinlgePoolElement(r);case"list_pool_element":let s=M.readArray("elements",n.fromJson)??[];return new n.ListPoolElement(s);case"feature_pool_element":return new n.FeaturePoolElement;default:return new n.EmptyPoolElement}}};(function(n){class t extends n{getBoundingBox(a,o){throw new Error("Invalid call of EmptyPoolElement")}getShuffledJigsawBlocks(a,o){return[]}toString(){return"[Empty Pool Element]"}}n.EmptyPoolElement=t;class e extends n{defaultJigsawNBT;constructor(){super();let a=new Map;a.set("name",new jt("minecraft:bottom")),a.set("final_state",new jt("minecraft:air")),a.set("pool",new jt("minecraft:empty")),a.set("target",new jt("minecraft:empty")),a.set("joint",new jt("rollable")),this.defaultJigsawNBT=new Et(a)}getBoundingBox(a,o){return[a,a]}getShuffledJigsawBlocks(a,o){return[{pos:[0,0,0],state:new Tt(T.create("jigsaw"),{orientation:"down_south"}),nbt:this.defaultJigsawNBT}]}toString(){return"[Feature Pool Element]"}}n.FeaturePoolElement=e;class i extends n{template;static JIGSAW_ID=T.parse("jigsaw");constructor(a){super(),this.template=a}getBoundingBox(a,o){let h=ot.offset(this.template.value().getSize(),-1,-1,-1),l=a,c=ot.add(Hn.transform(h,o,ot.ZERO),a),u=ot.create(Math.min(l[0],c[0]),l[1],Math.min(l[2],c[2])),d=ot.create(Math.max(l[0],c[0]),c[1],Math.max(l[2],c[2]));return[u,d]}getShuffledJigsawBlocks(a,o){let h=this.template.value().getBlocks().filter(l=>l.state.getName().equals(i.JIGSAW_ID));return h.forEach(l=>l.pos=Hn.transform(l.pos,a,ot.ZERO)),gh(h,o),h}toString(){return`[Single Pool Element: ${this.template.key()}]`}}n.SinlgePoolElement=i;class r extends n{elements;constructor(a){super(),this.elements=a}getBoundingBox(a,o){var h=void 0,l=void 0;for(let c of this.elements){let u=c.getBoundingBox(a,o);!h||!l?(h=u[0],l=u[1]):(h[0]=Math.min(h[0],u[0][0]),h[1]=Math.min(h[1],u[0][1]),h[2]=Math.min(h[2],u[0][2]),l[0]=Math.min(h[0],u[1][0]),l[1]=Math.min(h[1],u[1][1]),l[2]=Math.min(h[2],u[1][2]))}return[h,l]}getShuffledJigsawBlocks(a,o){return this.elements[0].getShuffledJigsawBlocks(a,o)}toString(){return`[List Pool Element: ${"; ".concat(...this.elements.map(a=>a.toString()))}]`}}n.ListPoolElement=r})(je=je||(je={}));var Ar=class n{rawTemplates;fallback;static REGISTRY=Gt.createAndRegister("worldgen/template_pool",n.fromJson);totalWeight;constructor(t,e){this.rawTemplates=t,this.fallback=e,this.totalWeight=t.reduce((i,r)=>i+r.weight,0)}static structurePoolParser=lt.parser(n.REGISTRY,n.fromJson);static fromJson(t){let e=M.readObject(t)??{},i=n.structurePoolParser(e.fallback??""),r=M.readArray(e.elements,s=>{let a=M.readObject(s)??{},o=je.fromJson(a.element),h=M.readInt(a.weight)??1;return{element:o,weight:h}})??[];return new n(r,i)}getRandomTemplate(t){var e=t.nextInt(this.totalWeight);for(let i of this.rawTemplates)if(e-=i.weight,e<0)return i.element;return this.rawTemplates[this.rawTemplates.length-1].element}};var qn=class{settings;constructor(t){this.settings=t}onTopOfChunkCenter(t,e,i,r="WORLD_SURFACE_WG"){let s=(e<<4)+8,a=(i<<4)+8;return[s,t.chunkGenerator.getBaseHeight(s,a,r,t.randomState)-1,a]}getLowestY(t,e,i,r,s){return Math.min(t.chunkGenerator.getBaseHeight(e,i,"WORLD_SURFACE_WG",t.randomState)-1,t.chunkGenerator.getBaseHeight(e,i+s,"WORLD_SURFACE_WG",t.randomState)-1,t.chunkGenerator.getBaseHeight(e+r,i,"WORLD_SURFACE_WG",t.randomState)-1,t.chunkGenerator.getBaseHeight(e+r,i+s,"WORLD_SURFACE_WG",t.randomState)-1)}getLowestYIn5by5BoxOffset7Blocks(t,e,i,r){let s=5,a=5;r===Xt.CLOCKWISE_90?s=-5:r===Xt.CLOCKWISE_180?(s=-5,a=-5):r===Xt.COUNTERCLOCKWISE_90&&(a=-5);let o=(e<<4)+7,h=(i<<4)+7;return ot.create(o,this.getLowestY(t,o,h,s,a),h)}tryGenerate(t,e,i){let r=zt.fromLargeFeatureSeed(i.seed,t,e),s=this.findGenerationPoint(t,e,r,i);if(s===void 0)return;let a=i.biomeSource.getBiome(s[0]>>2,s[1]>>2,s[2]>>2,i.randomState.sampler);return[...this.settings.validBiomes.getEntries()].findIndex(o=>o.key()?.equals(a))>=0?s:void 0}};(function(n){n.REGISTRY=Gt.createAndRegister("worldgen/structure",i);class t{validBiomes;constructor(b){this.validBiomes=b}}n.StructureSettings=t;let e=lt.parser(Ar.REGISTRY,Ar.fromJson);function i(w){let b=yn.parser(qt.BIOME),A=M.readObject(w)??{},I=b(A.biomes),C=new t(I.value());switch(M.readString(A.type)?.replace(/^minecraft:/,"")){case"buried_treasure":return new s(C);case"desert_pyramid":return new o(C);case"end_city":return new h(C);case"fortress":return new l(C);case"igloo":return new c(C);case"jigsaw":let P=Er.fromJson(A.start_height),L=e(A.start_pool),G=M.readString(A.start_jigsaw_name),q=G?T.parse(G):void 0,V=wr.fromJson(A.project_start_to_heightmap),B=r.DimensionPadding.fromJson(A.dimension_padding);return new r(C,L,P,V,q,B);case"jungle_temple":return new u(C);case"mineshaft":let pt=M.readString(A.mineshaft_type)==="mesa"?"mesa":"normal";return new d(C,pt);case"nether_fossil":return new l(C);case"ocean_monument":return new p(C);case"ocean_ruin":return new m(C);case"ruined_portal":return new g(C);case"shipwreck":let at=M.readBoolean(A.is_beached)??!1;return new _(C,at);case"stronghold":return new y(C);case"swamp_hut":return new v(C);case"woodland_mansion":return new x(C)}return new s(C)}n.fromJson=i;class r extends n{startingPoolHolder;startHeight;projectStartToHeightmap;startJigsawName;dimensionPadding;constructor(b,A,I,C,P,L){super(b),this.startingPoolHolder=A,this.startHeight=I,this.projectStartToHeightmap=C,this.startJigsawName=P,this.dimensionPadding=L}findGenerationPoint(b,A,I,C){let P=this.startHeight(I,C.chunkGenerator.getWorldgenContext()),L=ot.create(b<<4,P,A<<4),G=Xt.getRandom(I),V=this.startingPoolHolder.value().getRandomTemplate(I);if(!(V instanceof je.EmptyPoolElement)){let B;if(this.startJigsawName){let Q=r.getRandomNamedJigsaw(V,this.startJigsawName,G,I);if(Q===void 0)return;B=Q}else B=ot.ZERO;let pt=ot.subtract(L,B),at=V.getBoundingBox(pt,G),N=(at[1][0]+at[0][0])/2^0,O=(at[1][2]+at[0][2])/2^0,H;return this.projectStartToHeightmap?H=L[1]+C.chunkGenerator.getBaseHeight(N,O,this.projectStartToHeightmap,C.randomState):H=pt[1],at.forEach(Q=>Q[1]+=H-at[0][1]-1),r.isStartTooCloseToWorldHeightLimits(this.dimensionPadding,at,C.levelHeight)?void 0:ot.create(N,H+B[1],O)}}static isStartTooCloseToWorldHeightLimits(b,A,I){if(b===r.DimensionPadding.ZERO)return!1;let C=I.minY+b.bottom,P=I.minY+I.height-b.top;return A[0][1]<C||A[1][1]>P}static getRandomNamedJigsaw(b,A,I,C){let P=b.getShuffledJigsawBlocks(I,C);for(let L of P)if(T.parse(L.nbt?.getString("name")??"minecraft:empty").equals(A))return L.pos}}n.JigsawStructure=r,(function(w){class b{top;bottom;static ZERO=new b(0,0);constructor(I,C){this.top=I,this.bottom=C}static fromJson(I){if(I===void 0)return b.ZERO;if(typeof I=="number")return new b(I,I);let C=M.readObject(I)??{};return new b(M.readInt(C.top)??0,M.readInt(C.bottom)??0)}}w.DimensionPadding=b})(r=n.JigsawStructure||(n.JigsawStructure={}));class s extends n{findGenerationPoint(b,A,I,C){return this.onTopOfChunkCenter(C,b,A,"OCEAN_FLOOR_WG")}}n.BuriedTreasureStructure=s;class a extends n{width;depth;constructor(b,A,I){super(b),this.width=A,this.depth=I}findGenerationPoint(b,A,I,C){if(!(this.getLowestY(C,b<<4,A<<4,this.width,this.depth)<C.chunkGenerator.getWorldgenContext().seaLevel))return this.onTopOfChunkCenter(C,b,A)}}class o extends a{constructor(b){super(b,21,21)}}n.DesertPyramidStructure=o;class h extends n{findGenerationPoint(b,A,I,C){let P=Xt.getRandom(I),L=this.getLowestYIn5by5BoxOffset7Blocks(C,b,A,P);if(!(L[1]<60))return L}}n.EndCityStructure=h;class l extends n{findGenerationPoint(b,A){return ot.create(b<<4,64,A<<4)}}n.NetherFortressStructure=l;class c extends n{findGenerationPoint(b,A,I,C){return this.onTopOfChunkCenter(C,b,A)}}n.IglooStructure=c;class u extends a{constructor(b){super(b,12,15)}}n.JungleTempleStructure=u;class d extends n{type;constructor(b,A){super(b),this.type=A}findGenerationPoint(b,A,I,C){throw new Error("Method not implemented.")}}n.MineshaftStructure=d;class f extends n{height;constructor(b,A){super(b),this.height=A}findGenerationPoint(b,A){throw new Error("Method not implemented.")}}n.NetherFossilStructure=f;class p extends n{findGenerationPoint(b,A){throw new Error("Method not implemented.")}}n.OceanMonumentStructure=p;class m extends n{findGenerationPoint(b,A,I,C){return this.onTopOfChunkCenter(C,b,A,"OCEAN_FLOOR_WG")}}n.OceanRuinStructure=m;class g extends n{findGenerationPoint(b,A){throw new Error("Method not implemented.")}}n.RuinedPortalStructure=g;class _ extends n{isBeached;constructor(b,A){super(b),this.isBeached=A}findGenerationPoint(b,A,I,C){return this.onTopOfChunkCenter(C,b,A,this.isBeached?"WORLD_SURFACE_WG":"OCEAN_FLOOR_WG")}}n.ShipwreckStructure=_;class y extends n{findGenerationPoint(b,A){return ot.create(b<<4,0,A<<4)}}n.StrongholdStructure=y;class v extends n{findGenerationPoint(b,A,I,C){return this.onTopOfChunkCenter(C,b,A)}}n.SwampHutStructure=v;class x extends n{findGenerationPoint(b,A,I,C){let P=Xt.getRandom(I),L=this.getLowestYIn5by5BoxOffset7Blocks(C,b,A,P);if(!(L[1]<60))return L}}n.WoodlandMansionStructure=x})(qn=qn||(qn={}));var Yn=class n{structures;placement;static REGISTRY=Gt.createAndRegister("worldgen/structure_set",n.fromJson);constructor(t,e){this.structures=t,this.placement=e}static fromJson(t){let e=M.readObject(t)??{},i=M.readArray(e.structures,n.StructureSelectionEntry.fromJson)??[],r=Zn.fromJson(e.placement);return new n(i,r)}getStructureInChunk(t,e,i){if(this.placement.prepare(i.biomeSource,i.randomState.sampler,i.seed),!!this.placement.isStructureChunk(i.seed,t,e)&&this.structures.length!==0)if(this.structures.length===1){let r=this.structures[0].structure.value().tryGenerate(t,e,i);if(r!==void 0)return{id:this.structures[0].structure.key(),pos:r}}else{let r=zt.fromLargeFeatureSeed(i.seed,t,e),s=Object.assign([],this.structures),a=s.reduce((o,h,l)=>o+h.weight,0);for(;s.length>0;){let o=r.nextInt(a),h,l;for([h,l]of s.entries())if(o-=l.weight,o<0)break;let c=l.structure.value().tryGenerate(t,e,i);if(c!==void 0)return{id:l.structure.key(),pos:c};s.splice(h,1),a-=l.weight}}}};(function(n){class t{structure;weight;constructor(i,r){this.structure=i,this.weight=r}static fromJson(i){let r=M.readObject(i)??{};return new t(lt.reference(qn.REGISTRY,T.parse(M.readString(r.structure)??"minecraft:empty")),M.readInt(r.weight)??1)}}n.StructureSelectionEntry=t})(Yn=Yn||(Yn={}));var Zn=class n{locateOffset;frequencyReductionMethod;frequency;salt;exclusionZone;constructor(t,e,i,r,s){this.locateOffset=t,this.frequencyReductionMethod=e,this.frequency=i,this.salt=r,this.exclusionZone=s}static fromJson(t){let e=M.readObject(t)??{},i=M.readString(e.type)?.replace(/^minecraft:/,""),r=ot.fromJson(e.locate_offset),s=n.FrequencyReducer.fromType(M.readString(e.frequency_reduction_method)??"default"),a=M.readNumber(e.frequency)??1,o=M.readInt(e.salt)??0,h="exclusion_zone"in e?n.ExclusionZone.fromJson(e.exclusion_zone):void 0;switch(i){case"random_spread":let l=M.readInt(e.spacing)??1,c=M.readInt(e.separation)??1,u=n.SpreadType.fromJson(e.spread_type);return new n.RandomSpreadStructurePlacement(r,s,a,o,h,l,c,u);case"concentric_rings":let d=M.readInt(e.distance)??1,f=M.readInt(e.spread)??1,p=M.readInt(e.count)??1,m=yn.parser(qt.BIOME)(e.preferred_biomes);return new n.ConcentricRingsStructurePlacement(r,s,a,o,h,d,f,p,m)}return new n.RandomSpreadStructurePlacement([0,0,0],n.FrequencyReducer.ProbabilityReducer,1,0,void 0,1,1,"linear")}isStructureChunk(t,e,i){return this.isPlacementChunk(t,e,i)?this.frequency<1&&!this.frequencyReductionMethod(t,this.salt,e,i,this.frequency)?!1:!(this.exclusionZone&&this.exclusionZone.isPlacementForbidden(t,e,i)):!1}prepare(t,e,i){}};(function(n){let t;(function(o){function h(f){switch(f){case"legacy_type_1":return d;case"legacy_type_2":return u;case"legacy_type_3":return c;default:return l}}o.fromType=h;function l(f,p,m,g,_){return zt.fromLargeFeatureWithSalt(f,p,m,g).nextFloat()<_}o.ProbabilityReducer=l;function c(f,p,m,g,_){return zt.fromLargeFeatureSeed(f,m,g).nextDouble()<_}o.LegacyProbabilityReducerWithDouble=c;function u(f,p,m,g,_){return zt.fromLargeFeatureWithSalt(f,m,g,10387320).nextFloat()<_}o.LegacyArbitrarySaltProbabilityReducer=u;function d(f,p,m,g,_){let y=m>>4,v=g>>4,x=new zt(BigInt(y^v<<4)^f);return x.nextInt(),x.nextInt(Math.floor(1/_))===0}o.LegacyPillagerOutpostReducer=d})(t=n.FrequencyReducer||(n.FrequencyReducer={}));class e{otherSet;chunkCount;constructor(h,l){this.otherSet=h,this.chunkCount=l}static fromJson(h){let l=M.readObject(h)??{};return new e(lt.reference(Yn.REGISTRY,T.parse(M.readString(l.other_set)??"")),M.readInt(l.chunk_count)??1)}isPlacementForbidden(h,l,c){let u=this.otherSet.value().placement;return u.getPotentialStructureChunks(h,l-this.chunkCount,c-this.chunkCount,l+this.chunkCount,c+this.chunkCount).findIndex(d=>Math.abs(d[0]-l)<=this.chunkCount&&Math.abs(d[1]-c)<=this.chunkCount&&u.isStructureChunk(h,d[0],d[1]))>=0}}n.ExclusionZone=e;let i;(function(o){function h(l){return(M.readString(l)??"linear")==="triangular"?"triangular":"linear"}o.fromJson=h})(i=n.SpreadType||(n.SpreadType={}));class r extends n{spacing;separation;spreadType;constructor(h,l,c,u,d,f,p,m){super(h,l,c,u,d),this.spacing=f,this.separation=p,this.spreadType=m}evaluateSpread(h,l){switch(this.spreadType){case"linear":return h.nextInt(l);case"triangular":return Math.floor((h.nextInt(l)+h.nextInt(l))/2)}}getPotentialStructureChunk(h,l,c){let u=Math.floor(l/this.spacing),d=Math.floor(c/this.spacing),f=zt.fromLargeFeatureWithSalt(h,u,d,this.salt),p=this.spacing-this.separation,m=this.evaluateSpread(f,p),g=this.evaluateSpread(f,p);return[u*this.spacing+m,d*this.spacing+g]}isPlacementChunk(h,l,c){let[u,d]=this.getPotentialStructureChunk(h,l,c);return u===l&&d===c}getPotentialStructureChunks(h,l,c,u,d){let f=[];for(let p=Math.floor(l/this.spacing)*this.spacing;p<=u;p+=this.spacing)for(let m=Math.floor(c/this.spacing)*this.spacing;m<=d;m+=this.spacing)f.push(this.getPotentialStructureChunk(h,p,m));return f}}n.RandomSpreadStructurePlacement=r;let s=112;class a extends n{distance;spread;count;preferredBiomes;positions;constructor(h,l,c,u,d,f,p,m,g){super(h,l,c,u,d),this.distance=f,this.spread=p,this.count=m,this.preferredBiomes=g}prepare(h,l,c){if(this.positions!==void 0||(this.positions=[],this.count===0))return;let u=new zt(c);var d=u.nextDouble()*Math.PI*2,f=this.spread,p=0,m=0;let g=[...this.preferredBiomes.value().getEntries()].flatMap(y=>y.key()??[]);for(var _=0;_<this.count;_++){let y=4*this.distance+this.distance*p*6+(u.nextDouble()-.5)*this.distance*2.5,v=Math.round(Math.cos(d)*y),x=Math.round(Math.sin(d)*y),w=(v<<4)+8,b=(x<<4)+8,A=u.fork(),I=()=>{let C=br.findBiomeHorizontal(h,w,0,b,s,P=>g.findIndex(L=>L.equals(P))>=0,A,l);return C?[C.pos[0]>>4,C.pos[2]>>4]:[v,x]};this.positions.push({center:[v,x],real:I}),d+=Math.PI*2/f,m++,m==f&&(p++,m=0,f+=2*f/(p+1),f=Math.min(f,this.count-_),d+=u.nextDouble()*Math.PI*2)}}isPlacementChunk(h,l,c){return this.positions===void 0?(console.warn("trying to access concentric rings placement before position calculation"),!1):this.getPotentialStructureChunks(h,l,c,l,c).findIndex(u=>u[0]===l&&u[1]===c)>=0}getPotentialStructureChunks(h,l,c,u,d){if(this.positions===void 0)return console.warn("trying to access concentric rings placement before position calculation"),[];let f=[];for(let p of this.positions)p.center[0]<l-(s>>4)||p.center[0]>u+(s>>4)||p.center[1]<c-(s>>4)||p.center[1]>d+(s>>4)||(p.real instanceof Function&&(p.real=p.real()),f.push(p.real));return f}}n.ConcentricRingsStructurePlacement=a})(Zn=Zn||(Zn={}));var ue=class n{pos;color;texture;textureLimit;normal;blockPos;static VEC=fn.create();constructor(t,e,i,r,s,a){this.pos=t,this.color=e,this.texture=i,this.textureLimit=r,this.normal=s,this.blockPos=a}transform(t){return n.VEC[0]=this.pos.x,n.VEC[1]=this.pos.y,n.VEC[2]=this.pos.z,fn.transformMat4(n.VEC,n.VEC,t),this.pos=new Bt(n.VEC[0],n.VEC[1],n.VEC[2]),this}static fromPos(t){return new n(t,[0,0,0],[0,0],[0,0,0,0],void 0,void 0)}};var $s=class n{v1;v2;constructor(t,e){this.v1=t,this.v2=e}vertices(){return[this.v1,this.v2]}forEach(t){return t(this.v1),t(this.v2),this}transform(t){return this.forEach(e=>e.transform(t)),this}setColor(t){return this.forEach(e=>e.color=t),this}toString(){return`Line(${this.v1.pos.toString()}, ${this.v2.pos.toString()})`}static fromPoints(t,e){return new n(ue.fromPos(t),ue.fromPos(e))}};var dt=class{quads;lines;posBuffer;colorBuffer;textureBuffer;textureLimitBuffer;normalBuffer;blockPosBuffer;indexBuffer;linePosBuffer;lineColorBuffer;constructor(t=[],e=[]){this.quads=t,this.lines=e}clear(){return this.quads=[],this.lines=[],this}isEmpty(){return this.quads.length===0&&this.lines.length===0}quadVertices(){return this.quads.length*4}quadIndices(){return this.quads.length*6}lineVertices(){return this.lines.length*2}merge(t){return this.quads=this.quads.concat(t.quads),this.lines=this.lines.concat(t.lines),this}addLine(t,e,i,r,s,a,o){let h=new $s(ue.fromPos(new Bt(t,e,i)),ue.fromPos(new Bt(r,s,a))).setColor(o);return this.lines.push(h),this}addLineCube(t,e,i,r,s,a,o){return this.addLine(t,e,i,t,e,a,o),this.addLine(r,e,i,r,e,a,o),this.addLine(t,e,i,r,e,i,o),this.addLine(t,e,a,r,e,a,o),this.addLine(t,e,i,t,s,i,o),this.addLine(r,e,i,r,s,i,o),this.addLine(t,e,a,t,s,a,o),this.addLine(r,e,a,r,s,a,o),this.addLine(t,s,i,t,s,a,o),this.addLine(r,s,i,r,s,a,o),this.addLine(t,s,i,r,s,i,o),this.addLine(t,s,a,r,s,a,o),this}transform(t){for(let e of this.quads)e.transform(t);return this}computeNormals(){for(let t of this.quads){let e=t.normal();t.forEach(i=>i.normal=e)}}rebuild(t,e){let i=(s,a,o)=>{if(s||(s=t.createBuffer()??void 0),!s)throw new Error("Cannot create new buffer");return t.bindBuffer(a,s),t.bufferData(a,o,t.DYNAMIC_DRAW),s},r=(s,a,o)=>{if(s.length===0){a&&t.deleteBuffer(a);return}let h=s.flatMap(l=>l.vertices().flatMap(c=>{let u=o(c);if(!u)throw new Error("Missing vertex component");return u}));return i(a,t.ARRAY_BUFFER,new Float32Array(h))};return e.pos&&(this.posBuffer=r(this.quads,this.posBuffer,s=>s.pos.components()),this.linePosBuffer=r(this.lines,this.linePosBuffer,s=>s.pos.components())),e.color&&(this.colorBuffer=r(this.quads,this.colorBuffer,s=>s.color),this.lineColorBuffer=r(this.lines,this.lineColorBuffer,s=>s.color)),e.texture&&(this.textureBuffer=r(this.quads,this.textureBuffer,s=>s.texture),this.textureLimitBuffer=r(this.quads,this.textureLimitBuffer,s=>s.textureLimit)),e.normal&&(this.normalBuffer=r(this.quads,this.normalBuffer,s=>s.normal?.components())),e.blockPos&&(this.blockPosBuffer=r(this.quads,this.blockPosBuffer,s=>s.blockPos?.components())),this.quads.length===0?(this.indexBuffer&&t.deleteBuffer(this.indexBuffer),this.indexBuffer=void 0):this.indexBuffer=i(this.indexBuffer,t.ELEMENT_ARRAY_BUFFER,new Uint16Array(this.quads.flatMap((s,a)=>[4*a,4*a+1,4*a+2,a*4,4*a+2,4*a+3],!0))),this}};var Ks=class n{variants;multipart;constructor(t,e){this.variants=t,this.multipart=e}getModelVariants(t){if(this.variants){let e=Object.keys(this.variants).filter(r=>this.matchesVariant(r,t));if(e.length===0)return[];let i=this.variants[e[0]];return[Array.isArray(i)?i[0]:i]}else if(this.multipart)return this.multipart.filter(i=>i.when?this.matchesCase(i.when,t):!0).map(i=>Array.isArray(i.apply)?i.apply[0]:i.apply);return[]}getMesh(t,e,i,r,s){let a=this.getModelVariants(e),o=new dt;for(let l of a){let c=ht.rotate(s,l.x??0,l.y??0),u=r.getBlockModel(T.parse(l.model));if(!u)throw new Error(`Cannot find block model ${l.model}`);let d=t?Ie[t.path]?.(e):void 0,f=u.getMesh(i,c,d);if(l.x||l.y){let p=R.create();R.translate(p,p,[8,8,8]),R.rotateY(p,p,-$e.toRadian(l.y??0)),R.rotateX(p,p,-$e.toRadian(l.x??0)),R.translate(p,p,[-8,-8,-8]),f.transform(p)}o.merge(f)}let h=R.create();return R.scale(h,h,[.0625,.0625,.0625]),o.transform(h)}matchesVariant(t,e){return t.split(",").every(i=>{let[r,s]=i.split("=");return e[r]===s})}matchesCase(t,e){if(Array.isArray(t.OR))return t.OR.some(r=>this.matchesCase(r,e));if(Array.isArray(t.AND))return t.AND.every(r=>this.matchesCase(r,e));if(Array.isArray(t.AND))return t.AND.every(r=>this.matchesCase(r,e));let i=t;return Object.keys(i).every(r=>i[r].split("|").includes(e[r]))}static fromJson(t){return new n(t.variants,t.multipart)}};var Tr=class n{v1;v2;v3;v4;constructor(t,e,i,r){this.v1=t,this.v2=e,this.v3=i,this.v4=r}vertices(){return[this.v1,this.v2,this.v3,this.v4]}forEach(t){return t(this.v1),t(this.v2),t(this.v3),t(this.v4),this}transform(t){return this.forEach(e=>e.transform(t)),this}normal(){let t=this.v2.pos.sub(this.v1.pos),e=this.v3.pos.sub(this.v1.pos);return t.cross(e).normalize()}reverse(){return[this.v1,this.v2,this.v3,this.v4]=[this.v4,this.v3,this.v2,this.v1],this}setColor(t){return this.forEach(e=>e.color=t),this}setTexture(t,e){return this.v1.textureLimit=e,this.v2.textureLimit=e,this.v3.textureLimit=e,this.v4.textureLimit=e,this.v1.texture=[t[0],t[1]],this.v2.texture=[t[2],t[3]],this.v3.texture=[t[4],t[5]],this.v4.texture=[t[6],t[7]],this}toString(){return`Quad(${this.v1.pos.toString()}, ${this.v2.pos.toString()}, ${this.v3.pos.toString()}, ${this.v4.pos.toString()})`}static fromPoints(t,e,i,r){return new n(ue.fromPos(t),ue.fromPos(e),ue.fromPos(i),ue.fromPos(r))}};var t1={0:[0,3,2,3,2,1,0,1],90:[2,3,2,1,0,1,0,3],180:[2,1,0,1,0,3,2,3],270:[0,1,0,3,2,3,2,1]},e1={x:[1,0,0],y:[0,1,0],z:[0,0,1]},Ci=1.41421356237,n1={x:[1,Ci,Ci],y:[Ci,1,Ci],z:[Ci,Ci,1]},mt=class n{parent;textures;elements;display;guiLight;static BUILTIN_GENERATED=T.create("builtin/generated");static GENERATED_LAYERS=["layer0","layer1","layer2","layer3","layer4"];generationMarker=!1;constructor(t,e,i,r,s){this.parent=t,this.textures=e,this.elements=i,this.display=r,this.guiLight=s}getDisplayTransform(t){let e=this.display?.[t],i=R.create();return R.translate(i,i,[8,8,8]),e?.translation&&R.translate(i,i,e.translation),e?.rotation&&(R.rotateX(i,i,e.rotation[0]*Math.PI/180),R.rotateY(i,i,e.rotation[1]*Math.PI/180),R.rotateZ(i,i,-e.rotation[2]*Math.PI/180)),e?.scale&&R.scale(i,i,e.scale),R.translate(i,i,[-8,-8,-8]),i}getMesh(t,e,i){let r=new dt,s=a=>i===void 0?[1,1,1]:a===void 0||a<0?[1,1,1]:typeof i=="function"?i(a):i;for(let a of this.elements??[])r.merge(this.getElementMesh(a,t,e,s));return r}getElementMesh(t,e,i,r){let s=new dt,[a,o,h]=t.from,[l,c,u]=t.to,d=(p,m,g)=>{let _=Tr.fromPoints(new Bt(g[0],g[1],g[2]),new Bt(g[3],g[4],g[5]),new Bt(g[6],g[7],g[8]),new Bt(g[9],g[10],g[11])),y=r(p.tintindex);_.setColor(y);let[v,x,w,b]=e.getTextureUV(this.getTexture(p.texture)),A=(w-v)/16,I=(b-x)/16;m[0]=(p.uv?.[0]??m[0])*A,m[1]=(p.uv?.[1]??m[1])*I,m[2]=(p.uv?.[2]??m[2])*A,m[3]=(p.uv?.[3]??m[3])*I;let C=t1[p.rotation??0];_.setTexture([v+m[C[0]],x+m[C[1]],v+m[C[2]],x+m[C[3]],v+m[C[4]],x+m[C[5]],v+m[C[6]],x+m[C[7]]],[v+Math.min(m[0],m[2]),x+Math.min(m[1],m[3]),v+Math.max(m[0],m[2]),x+Math.max(m[1],m[3])]),s.quads.push(_)};t.faces?.up?.texture&&(!t.faces.up.cullface||!i[t.faces.up.cullface])&&d(t.faces.up,[a,16-u,l,16-h],[a,c,u,l,c,u,l,c,h,a,c,h]),t.faces?.down?.texture&&(!t.faces.down.cullface||!i[t.faces.down.cullface])&&d(t.faces.down,[16-u,16-l,16-h,16-a],[a,o,h,l,o,h,l,o,u,a,o,u]),t.faces?.south?.texture&&(!t.faces.south.cullface||!i[t.faces.south.cullface])&&d(t.faces.south,[a,16-c,l,16-o],[a,o,u,l,o,u,l,c,u,a,c,u]),t.faces?.north?.texture&&(!t.faces.north.cullface||!i[t.faces.north.cullface])&&d(t.faces.north,[16-l,16-c,16-a,16-o],[l,o,h,a,o,h,a,c,h,l,c,h]),t.faces?.east?.texture&&(!t.faces.east.cullface||!i[t.faces.east.cullface])&&d(t.faces.east,[16-u,16-c,16-h,16-o],[l,o,u,l,o,h,l,c,h,l,c,u]),t.faces?.west?.texture&&(!t.faces.west.cullface||!i[t.faces.west.cullface])&&d(t.faces.west,[h,16-c,u,16-o],[a,o,h,a,o,u,a,c,u,a,c,h]);let f=R.create();if(t.rotation){let p=fn.fromValues(...t.rotation.origin);R.translate(f,f,p),R.rotate(f,f,$e.toRadian(t.rotation.angle),e1[t.rotation.axis]),t.rotation.rescale&&R.scale(f,f,n1[t.rotation.axis]),fn.negate(p,p),R.translate(f,f,p)}return s.transform(f)}getTexture(t){for(t=t.startsWith("#")?t.slice(1):t,t=this.resolveTextureRef(t);t.startsWith("#");)t=this.resolveTextureRef(t.slice(1));return T.parse(t)}resolveTextureRef(t){let e=this.textures?.[t];return typeof e=="object"&&e!==null?e.sprite:e??""}flatten(t){if(!this.parent)return;if(this.parent.equals(n.BUILTIN_GENERATED)){this.generationMarker=!0;return}let e=this.getParent(t);if(!e){console.warn(`parent ${this.parent} does not exist!`),this.parent=void 0;return}if(e.flatten(t),this.elements||(this.elements=e.elements),this.textures||(this.textures={}),Object.keys(e.textures??{}).forEach(i=>{this.textures[i]||(this.textures[i]=e.textures[i])}),this.display||(this.display={}),Object.keys(e.display??{}).forEach(i=>{let r=i;this.display[r]?Object.keys(e.display[r]??{}).forEach(s=>{let a=s;this.display[r][a]||(this.display[r][a]=e.display[r][a])}):this.display[r]=e.display[r]}),this.guiLight||(this.guiLight=e.guiLight),e.generationMarker&&(this.generationMarker=!0),this.generationMarker&&(this.elements?.length??0)===0)for(let i=0;i<n.GENERATED_LAYERS.length;i+=1){let r=n.GENERATED_LAYERS[i];if(!Object.hasOwn(this.textures,r))break;this.elements||(this.elements=[]),this.elements.push({from:[0,0,0],to:[16,16,0],faces:{south:{texture:`#${r}`,tintindex:i}}})}this.parent=void 0}getParent(t){return this.parent?t.getBlockModel(this.parent):null}static fromJson(t){let e=t.parent===void 0?void 0:T.parse(t.parent);return new n(e,t.textures,t.elements,t.display)}};function wl(n,t,e,i,r){let s=i.up?16:[14.2,12.5,10.5,9,7,5.3,3.7,1.9,16,16,16,16,16,16,16,16][t];return new mt(void 0,{still:`block/${n}_still`,flow:`block/${n}_flow`},[{from:[0,0,0],to:[16,s,16],faces:{up:{texture:"#still",tintindex:r,cullface:At.UP},down:{texture:"#still",tintindex:r,cullface:At.DOWN},north:{texture:"#flow",tintindex:r,cullface:At.NORTH},east:{texture:"#flow",tintindex:r,cullface:At.EAST},south:{texture:"#flow",tintindex:r,cullface:At.SOUTH},west:{texture:"#flow",tintindex:r,cullface:At.WEST}}}]).getMesh(e,i,Ie[n]?.({}))}var Ii={white:Z.intToRgb(16383998),orange:Z.intToRgb(16351261),magenta:Z.intToRgb(13061821),light_blue:Z.intToRgb(3847130),yellow:Z.intToRgb(16701501),lime:Z.intToRgb(8439583),pink:Z.intToRgb(15961002),gray:Z.intToRgb(4673362),light_gray:Z.intToRgb(10329495),cyan:Z.intToRgb(1481884),purple:Z.intToRgb(8991416),blue:Z.intToRgb(3949738),brown:Z.intToRgb(8606770),green:Z.intToRgb(6192150),red:Z.intToRgb(11546150),black:Z.intToRgb(1908001)},wt;(function(n){function t(N){return O=>new mt(void 0,{0:N.withPrefix("entity/chest/").toString()},[{from:[1,0,1],to:[15,10,15],faces:{north:{uv:[10.5,8.25,14,10.75],rotation:180,texture:"#0"},east:{uv:[7,8.25,10.5,10.75],rotation:180,texture:"#0"},south:{uv:[3.5,8.25,7,10.75],rotation:180,texture:"#0"},west:{uv:[0,8.25,3.5,10.75],rotation:180,texture:"#0"},up:{uv:[7,4.75,10.5,8.25],texture:"#0"},down:{uv:[3.5,4.75,7,8.25],texture:"#0"}}},{from:[1,10,1],to:[15,14,15],faces:{north:{uv:[10.5,3.75,14,4.75],rotation:180,texture:"#0"},east:{uv:[7,3.75,10.5,4.75],rotation:180,texture:"#0"},south:{uv:[3.5,3.75,7,4.75],rotation:180,texture:"#0"},west:{uv:[0,3.75,3.5,4.75],rotation:180,texture:"#0"},up:{uv:[7,0,10.5,3.5],texture:"#0"},down:{uv:[3.5,0,7,3.5],texture:"#0"}}},{from:[7,7,0],to:[9,11,2],faces:{north:{uv:[.25,.25,.75,1.25],rotation:180,texture:"#0"},east:{uv:[0,.25,.25,1.25],rotation:180,texture:"#0"},south:{uv:[1,.25,1.5,1.25],rotation:180,texture:"#0"},west:{uv:[.75,.25,1,1.25],rotation:180,texture:"#0"},up:{uv:[.25,0,.75,.25],rotation:180,texture:"#0"},down:{uv:[.75,0,1.25,.25],rotation:180,texture:"#0"}}}]).getMesh(O,ht.none())}n.chestRenderer=t;function e(N){return new mt(void 0,{0:"entity/decorated_pot/decorated_pot_side",1:"entity/decorated_pot/decorated_pot_base"},[{from:[1,0,1],to:[15,16,15],faces:{north:{uv:[1,0,15,16],texture:"#0"},east:{uv:[1,0,15,16],texture:"#0"},south:{uv:[1,0,15,16],texture:"#0"},west:{uv:[1,0,15,16],texture:"#0"},up:{uv:[0,6.5,7,13.5],texture:"#1"},down:{uv:[7,6.5,14,13.5],texture:"#1"}}},{from:[5,16,5],to:[11,17,11],faces:{north:{uv:[0,5.5,3,6],texture:"#1"},east:{uv:[3,5.5,6,6],texture:"#1"},south:{uv:[6,5.5,9,6],texture:"#1"},west:{uv:[9,5.5,12,6],texture:"#1"}}},{from:[4,17,4],to:[12,20,12],faces:{north:{uv:[0,4,4,5.5],texture:"#1"},east:{uv:[4,4,8,5.5],texture:"#1"},south:{uv:[8,4,12,5.5],texture:"#1"},west:{uv:[12,4,16,5.5],texture:"#1"},up:{uv:[4,0,8,4],texture:"#1"},down:{uv:[8,0,12,4],texture:"#1"}}}]).getMesh(N,ht.none())}n.decoratedPotRenderer=e;let i=N=>({south:{uv:[.5,.5,3,5.5],texture:`#${N}`,tintindex:N}});function r(N,O){let H=j=>({from:[-5,-10,-.99],to:[5,10,-.99],faces:i(j)}),gt={0:"entity/shield/shield_base_nopattern"},Q=[{from:[-6,-11,-2],to:[6,11,-1],faces:{north:{uv:[3.5,.25,6.5,5.75],texture:"#0"},east:{uv:[3.25,.25,3.5,5.75],texture:"#0"},south:{uv:[.25,.25,3.25,5.75],texture:"#0"},west:{uv:[0,.25,.25,5.75],texture:"#0"},up:{uv:[.25,0,3.25,.25],texture:"#0"},down:{uv:[3.25,0,6.25,.25],texture:"#0"}}}],Rt=[""];return O?.forEach((j,S)=>{gt[S+1]=`entity/shield/${j.pattern}`,Q.push(H(S+1)),Rt.push(j.color)}),new mt(void 0,gt,Q).getMesh(N,ht.none(),j=>Ii[Rt[j]??""]??[1,1,1])}n.shieldRenderer=r;function s(N,O){return H=>new mt(void 0,{0:N.withPrefix("entity/").toString()},[{from:[4,0,4],to:[12,8,12],faces:{north:{uv:[6,2*O,8,4*O],texture:"#0"},east:{uv:[2,2*O,0,4*O],texture:"#0"},south:{uv:[2,2*O,4,4*O],texture:"#0"},west:{uv:[6,2*O,4,4*O],texture:"#0"},up:{uv:[2,0*O,4,2*O],texture:"#0"},down:{uv:[4,0*O,6,2*O],texture:"#0"}}}]).getMesh(H,ht.none())}n.headRenderer=s;function a(N=T.create("enderdragon/dragon")){return O=>{let H=R.create();return R.translate(H,H,[8,8,8]),R.scale(H,H,[.75,.75,.75]),R.rotateY(H,H,Math.PI),R.translate(H,H,[-8,-11.2,-8]),new mt(void 0,{0:N.withPrefix("entity/").toString()},[{from:[2,4,-16],to:[14,9,0],faces:{north:{uv:[12,3.75,12.75,4.0625],texture:"#0"},east:{uv:[11,3.75,12,4.0625],texture:"#0"},south:{uv:[13.75,3.75,14.5,4.0625],texture:"#0"},west:{uv:[12.75,3.75,13.75,4.0625],texture:"#0"},up:{uv:[12.75,3.75,12,2.75],texture:"#0"},down:{uv:[13.5,2.75,12.75,3.75],texture:"#0"}}},{from:[0,0,-2],to:[16,16,14],faces:{north:{uv:[8,2.875,9,3.875],texture:"#0"},east:{uv:[7,2.875,8,3.875],texture:"#0"},south:{uv:[10,2.875,11,3.875],texture:"#0"},west:{uv:[9,2.875,10,3.875],texture:"#0"},up:{uv:[9,2.875,8,1.875],texture:"#0"},down:{uv:[10,1.875,9,2.875],texture:"#0"}}},{from:[2,0,-16],to:[14,4,0],rotation:{angle:-.2*180/Math.PI,axis:"x",origin:[8,4,-2]},faces:{north:{uv:[12,5.0625,12.75,5.3125],texture:"#0"},east:{uv:[11,5.0625,12,5.3125],texture:"#0"},south:{uv:[13.75,5.0625,14.5,5.3125],texture:"#0"},west:{uv:[12.75,5.0625,13.75,5.3125],texture:"#0"},up:{uv:[12.75,5.0625,12,4.0625],texture:"#0"},down:{uv:[13.5,4.0625,12.75,5.0625],texture:"#0"}}},{from:[3,16,4],to:[5,20,10],faces:{north:{uv:[.375,.375,.5,.625],texture:"#0"},east:{uv:[0,.375,.375,.625],texture:"#0"},south:{uv:[.875,.375,1,.625],texture:"#0"},west:{uv:[.5,.375,.875,.625],texture:"#0"},up:{uv:[.5,.375,.375,0],texture:"#0"},down:{uv:[.625,0,.5,.375],texture:"#0"}}},{from:[11,16,4],to:[13,20,10],faces:{north:{uv:[.375,.375,.5,.625],texture:"#0"},east:{uv:[0,.375,.375,.625],texture:"#0"},south:{uv:[.875,.375,1,.625],texture:"#0"},west:{uv:[.5,.375,.875,.625],texture:"#0"},up:{uv:[.5,.375,.375,0],texture:"#0"},down:{uv:[.625,0,.5,.375],texture:"#0"}}},{from:[3,9,-14],to:[5,11,-10],faces:{north:{uv:[7.25,.25,7.375,.375],texture:"#0"},east:{uv:[7,.25,7.25,.375],texture:"#0"},south:{uv:[7.625,.25,7.75,.375],texture:"#0"},west:{uv:[7.375,.25,7.625,.375],texture:"#0"},up:{uv:[7.375,.25,7.25,0],texture:"#0"},down:{uv:[7.5,0,7.375,.25],texture:"#0"}}},{from:[11,9,-14],to:[13,11,-10],faces:{north:{uv:[7.25,.25,7.375,.375],texture:"#0"},east:{uv:[7,.25,7.25,.375],texture:"#0"},south:{uv:[7.625,.25,7.75,.375],texture:"#0"},west:{uv:[7.375,.25,7.625,.375],texture:"#0"},up:{uv:[7.375,.25,7.25,0],texture:"#0"},down:{uv:[7.5,0,7.375,.25],texture:"#0"}}}]).getMesh(O,ht.none()).transform(H)}}n.dragonHeadRenderer=a;function o(N=T.create("piglin/piglin")){return O=>new mt(void 0,{0:N.withPrefix("entity/").toString()},[{from:[3,0,4],to:[13,8,12],faces:{north:{uv:[6.5,2,9,4],texture:"#0"},east:{uv:[2,2,0,4],texture:"#0"},south:{uv:[2,2,4.5,4],texture:"#0"},west:{uv:[6.5,2,4.5,4],texture:"#0"},up:{uv:[2,0,4.5,2],texture:"#0"},down:{uv:[4.5,0,7,2],texture:"#0"}}},{from:[6,0,12],to:[10,4,13],faces:{north:{uv:[9.25,.5,10.25,1.5],texture:"#0"},east:{uv:[7.75,.5,8,1.5],texture:"#0"},south:{uv:[8,.5,9,1.5],texture:"#0"},west:{uv:[9,.5,9.25,1.5],texture:"#0"},up:{uv:[8,.25,9,.5],texture:"#0"},down:{uv:[9,.25,10,.5],texture:"#0"}}},{from:[5,0,12],to:[6,2,13],faces:{north:{uv:[1.25,.25,1.5,.75],texture:"#0"},east:{uv:[.5,.25,.75,.75],texture:"#0"},south:{uv:[.75,.25,1,.75],texture:"#0"},west:{uv:[1,.25,1.25,.75],texture:"#0"},up:{uv:[.75,0,1,.25],texture:"#0"},down:{uv:[1,0,1.25,.25],texture:"#0"}}},{from:[10,0,12],to:[11,2,13],faces:{north:{uv:[1.25,1.25,1.5,1.75],texture:"#0"},east:{uv:[.5,1.25,.75,1.75],texture:"#0"},south:{uv:[.75,1.25,1,1.75],texture:"#0"},west:{uv:[1,1.25,1.25,1.75],texture:"#0"},up:{uv:[.75,1,1,1.25],texture:"#0"},down:{uv:[1,1,1.25,1.25],texture:"#0"}}},{from:[2.5,1.5,6],to:[3.5,6.5,10],rotation:{angle:-30,axis:"z",origin:[3,7,8]},faces:{north:{uv:[12,2.5,12.25,3.75],texture:"#0"},east:{uv:[9.75,2.5,10.75,3.75],texture:"#0"},south:{uv:[10.75,2.5,11,3.75],texture:"#0"},west:{uv:[11,2.5,12,3.75],texture:"#0"},up:{uv:[10.75,1.5,11,2.5],texture:"#0"},down:{uv:[11,1.5,11.25,2.5],texture:"#0"}}},{from:[12.5,1.5,6],to:[13.5,6.5,10],rotation:{angle:30,axis:"z",origin:[13,7,8]},faces:{north:{uv:[15.25,2.5,15,3.75],texture:"#0"},east:{uv:[15,2.5,14,3.75],texture:"#0"},south:{uv:[14,2.5,13.75,3.75],texture:"#0"},west:{uv:[13.75,2.5,12.75,3.75],texture:"#0"},up:{uv:[14,1.5,13.75,2.5],texture:"#0"},down:{uv:[14.25,1.5,14,2.5],texture:"#0"}}}]).getMesh(O,ht.none())}n.piglinHeadRenderer=o;function h(N){return O=>new mt(void 0,{0:N.withPrefix("entity/signs/").toString()},[{from:[-4,8,7],to:[20,20,9],faces:{north:{uv:[.5,1,6.5,7],texture:"#0"},east:{uv:[0,1,.5,7],texture:"#0"},south:{uv:[7,1,13,7],texture:"#0"},west:{uv:[6.5,1,7,7],texture:"#0"},up:{uv:[6.5,1,.5,0],texture:"#0"},down:{uv:[12.5,0,6.5,1],texture:"#0"}}},{from:[7,-6,7],to:[9,8,9],faces:{north:{uv:[.5,8,1,15],texture:"#0"},east:{uv:[0,8,.5,15],texture:"#0"},south:{uv:[1.5,8,2,15],texture:"#0"},west:{uv:[1,8,1.5,15],texture:"#0"},up:{uv:[1,8,.5,7],texture:"#0"},down:{uv:[1.5,7,1,8],texture:"#0"}}}]).getMesh(O,ht.none())}n.signRenderer=h;function l(N){return O=>new mt(void 0,{0:N.withPrefix("entity/signs/").toString()},[{from:[-4,4,17],to:[20,16,19],faces:{north:{uv:[.5,1,6.5,7],texture:"#0"},east:{uv:[0,1,.5,7],texture:"#0"},south:{uv:[7,1,13,7],texture:"#0"},west:{uv:[6.5,1,7,7],texture:"#0"},up:{uv:[6.5,1,.5,0],texture:"#0"},down:{uv:[12.5,0,6.5,1],texture:"#0"}}}]).getMesh(O,ht.none())}n.wallSignRenderer=l;function c(N){return(O,H)=>O?new mt(void 0,{0:N.withPrefix("entity/signs/hanging/").toString()},[{from:[1,0,7],to:[15,10,9],faces:{north:{uv:[.5,7,4,12],texture:"#0"},east:{uv:[0,7,.5,12],texture:"#0"},south:{uv:[4.5,7,8,12],texture:"#0"},west:{uv:[4,7,4.5,12],texture:"#0"},up:{uv:[4,7,.5,6],texture:"#0"},down:{uv:[7.5,6,4,7],texture:"#0"}}},{from:[2,10,8],to:[14,16,8],faces:{north:{uv:[3.5,3,6.5,6],texture:"#0"},south:{uv:[3.5,3,6.5,6],texture:"#0"}}}]).getMesh(H,ht.none()):new mt(void 0,{0:N.withPrefix("entity/signs/hanging/").toString()},[{from:[1,0,7],to:[15,10,9],faces:{north:{uv:[.5,7,4,12],texture:"#0"},east:{uv:[0,7,.5,12],texture:"#0"},south:{uv:[4.5,7,8,12],texture:"#0"},west:{uv:[4,7,4.5,12],texture:"#0"},up:{uv:[4,7,.5,6],texture:"#0"},down:{uv:[7.5,6,4,7],texture:"#0"}}},{from:[1.5,10,8],to:[4.5,16,8],rotation:{angle:45,axis:"y",origin:[3,12,8]},faces:{north:{uv:[0,3,.75,6],texture:"#0"},south:{uv:[0,3,.75,6],texture:"#0"}}},{from:[3,10,6.5],to:[3,16,9.5],rotation:{angle:45,axis:"y",origin:[3,12,8]},faces:{east:{uv:[1.5,3,2.25,6],texture:"#0"},west:{uv:[1.5,3,2.25,6],texture:"#0"}}},{from:[11.5,10,8],to:[14.5,16,8],rotation:{angle:45,axis:"y",origin:[13,12,8]},faces:{north:{uv:[0,3,.75,6],texture:"#0"},south:{uv:[0,3,.75,6],texture:"#0"}}},{from:[13,10,6.5],to:[13,16,9.5],rotation:{angle:45,axis:"y",origin:[13,12,8]},faces:{east:{uv:[1.5,3,2.25,6],texture:"#0"},west:{uv:[1.5,3,2.25,6],texture:"#0"}}}]).getMesh(H,ht.none())}n.hangingSignRenderer=c;function u(N){return O=>new mt(void 0,{0:`entity/signs/hanging/${N}`},[{from:[1,0,7],to:[15,10,9],faces:{north:{uv:[.5,7,4,12],texture:"#0"},east:{uv:[0,7,.5,12],texture:"#0"},south:{uv:[4.5,7,8,12],texture:"#0"},west:{uv:[4,7,4.5,12],texture:"#0"},up:{uv:[4,7,.5,6],texture:"#0"},down:{uv:[7.5,6,4,7],texture:"#0"}}},{from:[0,14,6],to:[16,16,10],faces:{north:{uv:[1,2,5,3],texture:"#0"},east:{uv:[0,2,1,3],texture:"#0"},south:{uv:[6,2,10,3],texture:"#0"},west:{uv:[5,2,6,3],texture:"#0"},up:{uv:[5,2,1,0],texture:"#0"},down:{uv:[9,0,5,2],texture:"#0"}}},{from:[1.5,10,8],to:[4.5,16,8],rotation:{angle:45,axis:"y",origin:[3,12,8]},faces:{north:{uv:[0,3,.75,6],texture:"#0"},south:{uv:[0,3,.75,6],texture:"#0"}}},{from:[3,10,6.5],to:[3,16,9.5],rotation:{angle:45,axis:"y",origin:[3,12,8]},faces:{east:{uv:[1.5,3,2.25,6],texture:"#0"},west:{uv:[1.5,3,2.25,6],texture:"#0"}}},{from:[11.5,10,8],to:[14.5,16,8],rotation:{angle:45,axis:"y",origin:[13,12,8]},faces:{north:{uv:[0,3,.75,6],texture:"#0"},south:{uv:[0,3,.75,6],texture:"#0"}}},{from:[13,10,6.5],to:[13,16,9.5],rotation:{angle:45,axis:"y",origin:[13,12,8]},faces:{east:{uv:[1.5,3,2.25,6],texture:"#0"},west:{uv:[1.5,3,2.25,6],texture:"#0"}}}]).getMesh(O,ht.none())}n.wallHangingSignRenderer=u;function d(N){return new mt(void 0,{0:"entity/conduit/base"},[{from:[5,5,5],to:[11,11,11],faces:{north:{uv:[3,6,6,12],texture:"#0"},east:{uv:[0,6,3,12],texture:"#0"},south:{uv:[9,6,12,12],texture:"#0"},west:{uv:[6,6,9,12],texture:"#0"},up:{uv:[6,6,3,0],texture:"#0"},down:{uv:[9,0,6,6],texture:"#0"}}}]).getMesh(N,ht.none())}n.conduitRenderer=d;function f(N){return O=>new mt(void 0,{0:N.withPrefix("entity/shulker/").toString()},[{from:[0,0,0],to:[16,8,16],faces:{north:{uv:[4,11,8,13],texture:"#0"},east:{uv:[0,11,4,13],texture:"#0"},south:{uv:[12,11,16,13],texture:"#0"},west:{uv:[8,11,12,13],texture:"#0"},up:{uv:[8,11,4,7],texture:"#0"},down:{uv:[12,7,8,11],texture:"#0"}}},{from:[0,4,0],to:[16,16,16],faces:{north:{uv:[4,4,8,7],texture:"#0"},east:{uv:[0,4,4,7],texture:"#0"},south:{uv:[12,4,16,7],texture:"#0"},west:{uv:[8,4,12,7],texture:"#0"},up:{uv:[8,4,4,0],texture:"#0"},down:{uv:[12,0,8,4],texture:"#0"}}}]).getMesh(O,ht.none())}n.shulkerBoxRenderer=f;let p=N=>({north:{uv:[.25,.25,5.25,10.25],texture:`#${N}`,tintindex:N},east:{uv:[0,.25,.25,10.25],texture:`#${N}`,tintindex:N},south:{uv:[5.5,.25,10.5,10.25],texture:`#${N}`,tintindex:N},west:{uv:[5.25,.25,5.5,10.25],texture:`#${N}`,tintindex:N},up:{uv:[5.25,.25,.25,0],texture:`#${N}`,tintindex:N},down:{uv:[10.25,0,5.25,.25],texture:`#${N}`,tintindex:N}});function m(N,O){return(H,gt)=>{let Q={0:"entity/banner/banner_base"},Rt=[...O.base],j=[N];return gt?.forEach((S,E)=>{let D=T.parse(S.getString("pattern")).path,Y=S.getString("color");E++,Q[E]=`entity/banner/${D}`,Rt.push(O.pattern(E)),j.push(Y)}),new mt(void 0,Q,Rt).getMesh(H,ht.none(),S=>Ii[j[S]])}}n.bannerRenderer=N=>m(N,{base:[{from:[-2,-8,6],to:[18,32,7],faces:p(0)},{from:[7,-12,7],to:[9,30,9],faces:{north:{uv:[11.5,.5,12,11],texture:"#0"},east:{uv:[11,.5,11.5,11],texture:"#0"},south:{uv:[12.5,.5,13,11],texture:"#0"},west:{uv:[12,.5,12.5,11],texture:"#0"},up:{uv:[12,.5,11.5,0],texture:"#0"},down:{uv:[12.5,0,12,.5],texture:"#0"}}},{from:[-2,30,7],to:[18,32,9],faces:{north:{uv:[.5,11,5.5,11.5],texture:"#0"},east:{uv:[0,11,.5,11.5],texture:"#0"},south:{uv:[6,11,11,11.5],texture:"#0"},west:{uv:[5.5,11,6,11.5],texture:"#0"},up:{uv:[5.5,11,.5,10.5],texture:"#0"},down:{uv:[10.5,10.5,5.5,11],texture:"#0"}}}],pattern:O=>({from:[-2,-8,6],to:[18,32,7],faces:p(O)})}),n.wallBannerRenderer=N=>m(N,{base:[{from:[-2,-8,-1.5],to:[18,32,-.5],faces:p(0)},{from:[-2,30,-3.5],to:[18,32,-1.5],faces:{north:{uv:[.5,11,5.5,11.5],texture:"#0"},east:{uv:[0,11,.5,11.5],texture:"#0"},south:{uv:[6,11,11,11.5],texture:"#0"},west:{uv:[5.5,11,6,11.5],texture:"#0"},up:{uv:[5.5,11,.5,10.5],texture:"#0"},down:{uv:[10.5,10.5,5.5,11],texture:"#0"}}}],pattern:O=>({from:[-2,-8,-1.5],to:[18,32,-.5],faces:p(O)})});function g(N){return new mt(void 0,{0:"entity/bell/bell_body"},[{from:[5,3,5],to:[11,10,11],faces:{north:{uv:[3,3,6,6.5],texture:"#0"},east:{uv:[0,3,3,6.5],texture:"#0"},south:{uv:[9,3,12,6.5],texture:"#0"},west:{uv:[6,3,9,6.5],texture:"#0"},up:{uv:[6,3,3,0],texture:"#0"},down:{uv:[9,0,6,3],texture:"#0"}}},{from:[4,10,4],to:[12,12,12],faces:{north:{uv:[4,10.5,8,11.5],texture:"#0"},east:{uv:[0,10.5,4,11.5],texture:"#0"},south:{uv:[12,10.5,16,11.5],texture:"#0"},west:{uv:[8,10.5,12,11.5],texture:"#0"},up:{uv:[8,10.5,4,6.5],texture:"#0"},down:{uv:[12,6.5,8,10.5],texture:"#0"}}}]).getMesh(N,ht.none())}n.bellRenderer=g;function _(N){return(O,H)=>O==="foot"?new mt(void 0,{0:N.withPrefix("entity/bed/").toString()},[{from:[0,3,0],to:[16,9,16],faces:{north:{uv:[5.5,5.5,9.5,7],rotation:180,texture:"#0"},east:{uv:[0,7,1.5,11],rotation:270,texture:"#0"},west:{uv:[5.5,7,7,11],rotation:90,texture:"#0"},up:{uv:[5.5,11,1.5,7],texture:"#0"},down:{uv:[11,7,7,11],texture:"#0"}}},{from:[0,0,0],to:[3,3,3],faces:{north:{uv:[12.5,5.25,13.25,6],texture:"#0"},east:{uv:[14.75,5.25,15.5,6],texture:"#0"},south:{uv:[14,5.25,14.75,6],texture:"#0"},west:{uv:[13.25,5.25,14,6],texture:"#0"},up:{uv:[13.25,4.5,14,5.25],texture:"#0"},down:{uv:[14,4.5,14.75,5.25],texture:"#0"}}},{from:[13,0,0],to:[16,3,3],faces:{north:{uv:[13.25,3.75,14,4.5],texture:"#0"},east:{uv:[12.5,3.75,13.25,4.5],texture:"#0"},south:{uv:[14.75,3.75,15.5,4.5],texture:"#0"},west:{uv:[14,3.75,14.75,4.5],texture:"#0"},up:{uv:[13.25,3,14,3.75],texture:"#0"},down:{uv:[14,3,14.75,3.75],texture:"#0"}}}]).getMesh(H,ht.none()):new mt(void 0,{0:N.withPrefix("entity/bed/").toString()},[{from:[0,3,0],to:[16,9,16],faces:{east:{uv:[0,1.5,1.5,5.5],rotation:270,texture:"#0"},south:{uv:[1.5,0,5.5,1.5],rotation:180,texture:"#0"},west:{uv:[5.5,1.5,7,5.5],rotation:90,texture:"#0"},up:{uv:[5.5,5.5,1.5,1.5],texture:"#0"},down:{uv:[11,1.5,7,5.5],texture:"#0"}}},{from:[0,0,13],to:[3,3,16],faces:{north:{uv:[14.75,.75,15.5,1.5],texture:"#0"},east:{uv:[14,.75,14.75,1.5],texture:"#0"},south:{uv:[13.25,.75,14,1.5],texture:"#0"},west:{uv:[12.5,.75,13.25,1.5],texture:"#0"},up:{uv:[13.25,0,14,.75],texture:"#0"},down:{uv:[14,0,14.75,.75],texture:"#0"}}},{from:[13,0,13],to:[16,3,16],faces:{north:{uv:[14,2.25,14.75,3],texture:"#0"},east:{uv:[13.25,2.25,14,3],texture:"#0"},south:{uv:[12.5,2.25,13.25,3],texture:"#0"},west:{uv:[14.75,2.25,15.5,3],texture:"#0"},up:{uv:[13.25,1.5,14,2.25],texture:"#0"},down:{uv:[14,1.5,14.75,2.25],texture:"#0"}}}]).getMesh(H,ht.none())}n.bedRenderer=_;function y(N){return(O,H)=>{let gt=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[4,11,3],to:[12,16,13],faces:{east:{uv:[0,2.5,2.5,3.75],texture:"#0"},north:{uv:[2.5,2.5,4.5,3.75],texture:"#0"},west:{uv:[4.5,2.5,6.5,3.75],texture:"#0"},south:{uv:[7,2.5,9,3.75],texture:"#0"},up:{uv:[2.5,0,4.5,2.5],rotation:180,texture:"#0"},down:{uv:[4.5,0,6.5,2.5],rotation:180,texture:"#0"}}},{from:[7,10,2],to:[9,13,4],faces:{east:{uv:[14,.5,14.5,1.25],texture:"#0"},north:{uv:[14.5,.5,15,1.25],texture:"#0"},west:{uv:[15,.5,15.5,1.25],texture:"#0"},south:{uv:[15.5,.5,16,1.25],texture:"#0"},up:{uv:[14.5,0,15,.5],rotation:180,texture:"#0"},down:{uv:[15,0,15.5,.5],rotation:180,texture:"#0"}}},{from:[7,16,7],to:[9,20,9],faces:{east:{uv:[9.25,2.5,9.75,3.5],texture:"#0"},north:{uv:[9.75,2.5,10.25,3.5],texture:"#0"},west:{uv:[10.25,2.5,10.75,3.5],texture:"#0"},south:{uv:[10.75,2.5,11.25,3.5],texture:"#0"},up:{uv:[9.75,2,10.25,2.5],texture:"#0"},down:{uv:[10.25,2,10.75,2.5],texture:"#0"}}},{from:[6,20,6],to:[10,24,10],faces:{east:{uv:[9.25,1,10.25,2],texture:"#0"},north:{uv:[10.25,1,11.25,2],texture:"#0"},west:{uv:[11.25,1,12.25,2],texture:"#0"},south:{uv:[12.25,1,13.25,2],texture:"#0"},up:{uv:[10.25,0,11.25,1],rotation:180,texture:"#0"},down:{uv:[11.25,0,12.25,1],rotation:180,texture:"#0"}}}]).getMesh(O,ht.none()),Q=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[4,5,5],to:[12,11,11],faces:{east:{uv:[0,5.25,1.5,6.75],texture:"#0"},north:{uv:[1.5,5.25,3.5,6.75],texture:"#0"},west:{uv:[3.5,5.25,5,6.75],texture:"#0"},south:{uv:[5,5.25,7,6.75],texture:"#0"},up:{uv:[1.5,3.75,3.5,5.25],texture:"#0"},down:{uv:[3.5,3.75,5.5,5.25],texture:"#0"}}}]).getMesh(O,ht.none()),Rt=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[12,2,6],to:[15,12,10],faces:{east:{uv:[9,5,10,7.5],texture:"#0"},north:{uv:[10,5,10.75,7.5],texture:"#0"},west:{uv:[10.75,5,11.75,7.5],texture:"#0"},south:{uv:[11.75,5,12.5,7.5],texture:"#0"},up:{uv:[10,4,10.75,5],rotation:180,texture:"#0"},down:{uv:[10.75,4,11.5,5],rotation:180,texture:"#0"}}}]).getMesh(O,ht.none()),j=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[1,2,6],to:[4,12,10],faces:{east:{uv:[12.5,5,13.5,7.5],texture:"#0"},north:{uv:[13.5,5,14.25,7.5],texture:"#0"},west:{uv:[14.25,5,15.25,7.5],texture:"#0"},south:{uv:[15.25,5,16,7.5],texture:"#0"},up:{uv:[13.5,4,14.25,5],rotation:180,texture:"#0"},down:{uv:[14.25,4,15,5],rotation:180,texture:"#0"}}}]).getMesh(O,ht.none()),S=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[8,0,6],to:[12,5,10],faces:{east:{uv:[0,7.75,1,9],texture:"#0"},north:{uv:[1,7.75,2,9],texture:"#0"},west:{uv:[2,7.75,3,9],texture:"#0"},south:{uv:[3,7.75,4,9],texture:"#0"},up:{uv:[1,6.75,2,7.75],texture:"#0"},down:{uv:[2,6.75,3,7.75],texture:"#0"}}}]).getMesh(O,ht.none()),E=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[4,0,6],to:[8,5,10],faces:{east:{uv:[4,7.75,5,9],texture:"#0"},north:{uv:[5,7.75,6,9],texture:"#0"},west:{uv:[6,7.75,7,9],texture:"#0"},south:{uv:[7,7.75,8,9],texture:"#0"},up:{uv:[5,6.75,6,7.75],texture:"#0"},down:{uv:[6,6.75,7,7.75],texture:"#0"}}}]).getMesh(O,ht.none()),D=new dt;switch(H){case"sitting":let Y=R.create();R.translate(Y,Y,[0,-5,2]),D.merge(Q.transform(Y));let _t=new mt(void 0,{0:N.withPrefix("entity/copper_golem/").toString()},[{from:[5,6,6],to:[11,7,12],faces:{east:{uv:[.75,6.25,2.25,6.5],texture:"#0"},north:{uv:[2.25,6.25,3.75,6.5],texture:"#0"},west:{uv:[3.75,6.25,5.25,6.5],texture:"#0"},south:{uv:[5.25,6.25,6.75,6.5],texture:"#0"},up:{uv:[2.25,4.75,3.75,6.25],texture:"#0"},down:{uv:[3.75,4.75,5.25,6.25],texture:"#0"}}},{from:[4,1,4],to:[12,7,7],faces:{east:{uv:[.75,5.25,1.5,6.75],rotation:180,texture:"#0"},north:{uv:[1.5,5.25,3.5,6.75],rotation:180,texture:"#0"},west:{uv:[3.5,5.25,4.25,6.75],rotation:180,texture:"#0"},south:{uv:[4.25,5.25,6.25,6.75],rotation:180,texture:"#0"},up:{uv:[1.5,4.5,3.5,5.25],rotation:180,texture:"#0"},down:{uv:[3.5,4.75,5.5,5.5],rotation:180,texture:"#0"}}}]).getMesh(O,ht.none());D.merge(_t);let Yt=R.create();R.translate(Yt,Yt,[0,-4,0]),D.merge(gt.transform(Yt));let Pt=R.create();R.translate(Pt,Pt,[0,5.5,6.5]),R.rotateX(Pt,Pt,.61086524),R.translate(Pt,Pt,[0,-7,-8]),D.merge(Rt.transform(Pt)),D.merge(j.transform(Pt));let Nt=R.create();R.translate(Nt,Nt,[2.5,2.5,2]),R.rotateX(Nt,Nt,Math.PI/2),R.translate(Nt,Nt,[-2.5,-1,-7.5]),D.merge(S.transform(Nt)),D.merge(E.transform(Nt));break;case"running":let Ct=R.create();R.translate(Ct,Ct,[0,0,-2]),D.merge(gt.transform(Ct));let ut=R.create();R.translate(ut,ut,[0,0,-2]),R.translate(ut,ut,[-8,-8,-6]),R.rotateX(ut,ut,-.120399),R.rotateY(ut,ut,.0064),R.rotateZ(ut,ut,-.0779),R.translate(ut,ut,[6.4,7.5,9.5]),D.merge(Q.transform(ut));let W=R.create();R.translate(W,W,[0,7,8]),R.rotateX(W,W,-1.003564),R.translate(W,W,[0,-7,-5]),D.merge(Rt.transform(W));let F=R.create();R.translate(F,F,[0,7,8]),R.rotateX(F,F,.872665),R.rotateY(F,F,.0535),R.rotateZ(F,F,-.0449),R.translate(F,F,[0,-7,-10.25]),D.merge(j.transform(F));let it=R.create();R.translate(it,it,[10,2.5,4.6]),R.rotateX(it,it,.872665),R.translate(it,it,[-10.6,-1.5,-7.5]),D.merge(S.transform(it));let be=R.create();R.translate(be,be,[6,2.5,10]),R.rotateX(be,be,-.7854),R.translate(be,be,[-6.4,-1.5,-8]),D.merge(E.transform(be));break;case"star":D.merge(gt),D.merge(Q);let Pe=R.create();R.translate(Pe,Pe,[11,10,8]),R.rotateZ(Pe,Pe,1.91986),R.translate(Pe,Pe,[-13.5,-7,-8]),D.merge(Rt.transform(Pe));let Ne=R.create();R.translate(Ne,Ne,[5,10,8]),R.rotateZ(Ne,Ne,-1.91986),R.translate(Ne,Ne,[-2.5,-7,-8]),D.merge(j.transform(Ne));let tn=R.create();R.translate(tn,tn,[10.75,3,8]),R.rotateZ(tn,tn,.2618),R.translate(tn,tn,[-10,-2.5,-8]),D.merge(S.transform(tn));let en=R.create();R.translate(en,en,[5.25,3,8]),R.rotateZ(en,en,-.2618),R.translate(en,en,[-6,-2.5,-8]),D.merge(E.transform(en));break;default:D.merge(Q),D.merge(gt),D.merge(Rt),D.merge(j),D.merge(S),D.merge(E);break}return D}}n.copperGolemStatueRenderer=y;function v(N,O,H=""){return N.getProperty(O)??H}function x(N,O,H="0"){return parseInt(N.getProperty(O)??H)}let w=new Map(Object.entries({"minecraft:chest":n.chestRenderer(T.create("normal")),"minecraft:ender_chest":n.chestRenderer(T.create("ender")),"minecraft:trapped_chest":n.chestRenderer(T.create("trapped")),"minecraft:copper_chest":n.chestRenderer(T.create("copper")),"minecraft:exposed_copper_chest":n.chestRenderer(T.create("copper_exposed")),"minecraft:weathered_copper_chest":n.chestRenderer(T.create("copper_weathered")),"minecraft:oxidized_copper_chest":n.chestRenderer(T.create("copper_oxidized")),"minecraft:waxed_copper_chest":n.chestRenderer(T.create("copper")),"minecraft:waxed_exposed_copper_chest":n.chestRenderer(T.create("copper_exposed")),"minecraft:waxed_weathered_copper_chest":n.chestRenderer(T.create("copper_weathered")),"minecraft:waxed_oxidized_copper_chest":n.chestRenderer(T.create("copper_oxidized"))})),b=new Map(Object.entries({"minecraft:skeleton_skull":n.headRenderer(T.create("skeleton/skeleton"),2),"minecraft:wither_skeleton_skull":n.headRenderer(T.create("skeleton/wither_skeleton"),2),"minecraft:zombie_head":n.headRenderer(T.create("zombie/zombie"),1),"minecraft:creeper_head":n.headRenderer(T.create("creeper/creeper"),2),"minecraft:dragon_head":n.dragonHeadRenderer(),"minecraft:piglin_head":n.piglinHeadRenderer(),"minecraft:player_head":n.headRenderer(T.create("player/wide/steve"),1)})),A=["oak","spruce","birch","jungle","acacia","dark_oak","mangrove","cherry","pale_oak","bamboo","crimson","warped"],I=new Map(A.map(N=>[`minecraft:${N}_sign`,n.signRenderer(T.create(N))])),C=new Map(A.map(N=>[`minecraft:${N}_wall_sign`,n.wallSignRenderer(T.create(N))])),P=new Map(A.map(N=>[`minecraft:${N}_hanging_sign`,n.hangingSignRenderer(T.create(N))])),L=new Map(A.map(N=>[`minecraft:${N}_wall_hanging_sign`,n.wallHangingSignRenderer(N)])),G=new Map(Object.keys(Ii).map(N=>[`minecraft:${N}_shulker_box`,n.shulkerBoxRenderer(T.create(`shulker_${N}`))])),q=new Map(Object.keys(Ii).map(N=>[`minecraft:${N}_bed`,n.bedRenderer(T.create(N))])),V=new Map(Object.keys(Ii).map(N=>[`minecraft:${N}_banner`,n.bannerRenderer(N)])),B=new Map(Object.keys(Ii).map(N=>[`minecraft:${N}_wall_banner`,n.wallBannerRenderer(N)])),pt=new Map(Object.entries({"minecraft:copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem")),"minecraft:exposed_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem_exposed")),"minecraft:weathered_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem_weathered")),"minecraft:oxidized_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem_oxidized")),"minecraft:waxed_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem")),"minecraft:waxed_exposed_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem_exposed")),"minecraft:waxed_weathered_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem_weathered")),"minecraft:waxed_oxidized_copper_golem_statue":n.copperGolemStatueRenderer(T.create("copper_golem_oxidized"))}));function at(N,O,H,gt){let Q=new dt;N.is("water")&&Q.merge(wl("water",x(N,"level"),H,gt,0)),N.is("lava")&&Q.merge(wl("lava",x(N,"level"),H,gt));let Rt=w.get(N.getName().toString());if(Rt!==void 0){let W=v(N,"facing","south"),F=R.create();R.translate(F,F,[8,8,8]),R.rotateY(F,F,W==="west"?Math.PI/2:W==="south"?Math.PI:W==="east"?Math.PI*3/2:0),R.translate(F,F,[-8,-8,-8]),Q.merge(Rt(H).transform(F))}N.is("decorated_pot")&&Q.merge(e(H));let j=b.get(N.getName().toString());if(j!==void 0){let W=x(N,"rotation")/16*Math.PI*2,F=R.create();R.translate(F,F,[8,8,8]),R.rotateY(F,F,W),R.translate(F,F,[-8,-8,-8]),Q.merge(j(H).transform(F))}let S=I.get(N.getName().toString());if(S!==void 0){let W=x(N,"rotation")/16*Math.PI*2,F=R.create();R.translate(F,F,[8,8,8]),R.rotateY(F,F,W),R.scale(F,F,[2/3,2/3,2/3]),R.translate(F,F,[-8,-8,-8]),Q.merge(S(H).transform(F))}let E=C.get(N.getName().toString());if(E!==void 0){let W=v(N,"facing","south"),F=R.create();R.translate(F,F,[8,8,8]),R.rotateY(F,F,W==="west"?Math.PI/2:W==="south"?Math.PI:W==="east"?Math.PI*3/2:0),R.scale(F,F,[2/3,2/3,2/3]),R.translate(F,F,[-8,-8,-8]),Q.merge(E(H).transform(F))}let D=P.get(N.getName().toString());if(D!==void 0){let W=v(N,"attached","false")==="true",F=x(N,"rotation")/16*Math.PI*2,it=R.create();R.translate(it,it,[8,8,8]),R.rotateY(it,it,F),R.translate(it,it,[-8,-8,-8]),Q.merge(D(W,H).transform(it))}let Y=L.get(N.getName().toString());if(Y!==void 0){let W=v(N,"facing","south"),F=R.create();R.translate(F,F,[8,8,8]),R.rotateY(F,F,W==="west"?Math.PI/2:W==="south"?Math.PI:W==="east"?Math.PI*3/2:0),R.translate(F,F,[-8,-8,-8]),Q.merge(Y(H).transform(F))}N.is("conduit")&&Q.merge(d(H));let _t=G.get(N.getName().toString());if(_t!==void 0){let W=v(N,"facing","up"),F=R.create();R.translate(F,F,[8,8,8]),W==="down"?R.rotateX(F,F,Math.PI):W!=="up"&&(R.rotateY(F,F,W==="east"?Math.PI/2:W==="north"?Math.PI:W==="west"?Math.PI*3/2:0),R.rotateX(F,F,Math.PI/2)),R.translate(F,F,[-8,-8,-8]),Q.merge(_t(H).transform(F))}if(N.is("bell")){let W=R.create();R.translate(W,W,[8,8,8]),R.scale(W,W,[1,-1,-1]),R.translate(W,W,[-8,-8,-8]),Q.merge(g(H).transform(W))}let Yt=q.get(N.getName().toString());if(Yt!==void 0){let W=v(N,"part","head"),F=v(N,"facing","south"),it=R.create();R.translate(it,it,[8,8,8]),R.rotateY(it,it,F==="east"?Math.PI/2:F==="north"?Math.PI:F==="west"?Math.PI*3/2:0),R.translate(it,it,[-8,-8,-8]),Q.merge(Yt(W,H).transform(it))}let Pt=V.get(N.getName().toString());if(Pt!==void 0){let W=x(N,"rotation")/16*Math.PI*2,F=R.create();R.translate(F,F,[8,24,8]),R.rotateY(F,F,W),R.scale(F,F,[2/3,2/3,2/3]),R.translate(F,F,[-8,-24,-8]),Q.merge(Pt(H,O?.getList("patterns",U.Compound)).transform(F))}let Nt=B.get(N.getName().toString());if(Nt!==void 0){let W=v(N,"facing","south"),F=R.create();R.translate(F,F,[8,8,8]),R.rotateY(F,F,W==="east"?Math.PI/2:W==="north"?Math.PI:W==="west"?Math.PI*3/2:0),R.scale(F,F,[2/3,2/3,2/3]),R.translate(F,F,[-8,-23.2,-8]),Q.merge(Nt(H,O?.getList("patterns",U.Compound)).transform(F))}let Ct=pt.get(N.getName().toString());if(Ct!==void 0){let W=v(N,"facing","south"),F=v(N,"copper_golem_pose","standing"),it=R.create();R.translate(it,it,[8,8,8]),R.rotateY(it,it,W==="west"?Math.PI/2:W==="south"?Math.PI:W==="east"?Math.PI*3/2:0),R.translate(it,it,[-8,-8,-8]),Q.merge(Ct(H,F).transform(it))}!N.is("water")&&!N.is("lava")&&N.isWaterlogged()&&Q.merge(wl("water",0,H,gt,0));let ut=R.create();return R.scale(ut,ut,[.0625,.0625,.0625]),Q.transform(ut)}n.getBlockMesh=at})(wt=wt||(wt={}));var Pi=class{gl;program;constructor(t,e,i){this.gl=t,this.program=this.initShaderProgram(e,i)}getProgram(){return this.program}initShaderProgram(t,e){let i=this.loadShader(this.gl.VERTEX_SHADER,t),r=this.loadShader(this.gl.FRAGMENT_SHADER,e),s=this.gl.createProgram();if(this.gl.attachShader(s,i),this.gl.attachShader(s,r),this.gl.linkProgram(s),!this.gl.getProgramParameter(s,this.gl.LINK_STATUS))throw new Error(`Unable to link shader program: ${this.gl.getProgramInfoLog(s)}`);return s}loadShader(t,e){let i=this.gl.createShader(t);if(this.gl.shaderSource(i,e),this.gl.compileShader(i),!this.gl.getShaderParameter(i,this.gl.COMPILE_STATUS)){let r=new Error(`Compiling ${t===this.gl.VERTEX_SHADER?"vertex":"fragment"} shader: ${this.gl.getShaderInfoLog(i)}`);throw this.gl.deleteShader(i),r}return i}};var i1=`
  attribute vec4 vertPos;
  attribute vec2 texCoord;
  attribute vec4 texLimit;
  attribute vec3 vertColor;
  attribute vec3 normal;

  uniform mat4 mView;
  uniform mat4 mProj;

  varying highp vec2 vTexCoord;
  varying highp vec4 vTexLimit;
  varying highp vec3 vTintColor;
  varying highp float vLighting;

  void main(void) {
    gl_Position = mProj * mView * vertPos;
    vTexCoord = texCoord;
	vTexLimit = texLimit;
    vTintColor = vertColor;
    vLighting = normal.y * 0.2 + abs(normal.z) * 0.1 + 0.8;
  }
`,r1=`
  precision highp float;
  varying highp vec2 vTexCoord;
  varying highp vec4 vTexLimit;
  varying highp vec3 vTintColor;
  varying highp float vLighting;

  uniform sampler2D sampler;
  uniform highp float pixelSize;

  void main(void) {
		vec4 texColor = texture2D(sampler, clamp(vTexCoord,
			vTexLimit.xy + vec2(0.5, 0.5) * pixelSize,
			vTexLimit.zw - vec2(0.5, 0.5) * pixelSize
		));
		if(texColor.a < 0.01) discard;
		gl_FragColor = vec4(texColor.xyz * vTintColor * vLighting, texColor.a);
  }
`,Ni=class{gl;shaderProgram;projMatrix;activeShader;pixelSize=0;constructor(t){this.gl=t,this.shaderProgram=new Pi(t,i1,r1).getProgram(),this.activeShader=this.shaderProgram,this.projMatrix=this.getPerspective(),this.initialize()}setViewport(t,e,i,r){this.gl.viewport(t,e,i,r),this.projMatrix=this.getPerspective()}getPerspective(){let t=70*Math.PI/180,e=this.gl.canvas.clientWidth/this.gl.canvas.clientHeight,i=R.create();return R.perspective(i,t,e,.1,500),i}initialize(){this.gl.enable(this.gl.DEPTH_TEST),this.gl.depthFunc(this.gl.LEQUAL),this.gl.enable(this.gl.BLEND),this.gl.blendFunc(this.gl.SRC_ALPHA,this.gl.ONE_MINUS_SRC_ALPHA),this.gl.enable(this.gl.CULL_FACE),this.gl.cullFace(this.gl.BACK)}setShader(t){this.gl.useProgram(t),this.activeShader=t}setVertexAttr(t,e,i){if(i===void 0)throw new Error(`Expected buffer for ${t}`);let r=this.gl.getAttribLocation(this.activeShader,t);this.gl.bindBuffer(this.gl.ARRAY_BUFFER,i),this.gl.vertexAttribPointer(r,e,this.gl.FLOAT,!1,0,0),this.gl.enableVertexAttribArray(r)}setUniform(t,e){let i=this.gl.getUniformLocation(this.activeShader,t);this.gl.uniformMatrix4fv(i,!1,e)}setTexture(t,e){this.gl.activeTexture(this.gl.TEXTURE0),this.gl.bindTexture(this.gl.TEXTURE_2D,t),this.pixelSize=e??0}createAtlasTexture(t){let e=this.gl.createTexture();return this.gl.bindTexture(this.gl.TEXTURE_2D,e),this.gl.texImage2D(this.gl.TEXTURE_2D,0,this.gl.RGBA,this.gl.RGBA,this.gl.UNSIGNED_BYTE,t),this.gl.generateMipmap(this.gl.TEXTURE_2D),this.gl.texParameteri(this.gl.TEXTURE_2D,this.gl.TEXTURE_MAG_FILTER,this.gl.NEAREST),e}prepareDraw(t){this.setUniform("mView",t),this.setUniform("mProj",this.projMatrix);let e=this.gl.getUniformLocation(this.activeShader,"pixelSize");this.gl.uniform1f(e,this.pixelSize)}drawMesh(t,e){if(t.quadVertices()>0){if(e.pos&&this.setVertexAttr("vertPos",3,t.posBuffer),e.color&&this.setVertexAttr("vertColor",3,t.colorBuffer),e.texture&&(this.setVertexAttr("texCoord",2,t.textureBuffer),this.setVertexAttr("texLimit",4,t.textureLimitBuffer)),e.normal&&this.setVertexAttr("normal",3,t.normalBuffer),e.blockPos&&this.setVertexAttr("blockPos",3,t.blockPosBuffer),!t.indexBuffer)throw new Error("Expected index buffer");this.gl.bindBuffer(this.gl.ELEMENT_ARRAY_BUFFER,t.indexBuffer),this.gl.drawElements(this.gl.TRIANGLES,t.quadIndices(),this.gl.UNSIGNED_SHORT,0)}t.lineVertices()>0&&(e.pos&&this.setVertexAttr("vertPos",3,t.linePosBuffer),e.color&&this.setVertexAttr("vertColor",3,t.lineColorBuffer),this.gl.drawArrays(this.gl.LINES,0,t.lineVertices()))}};var Qs=class n extends Ni{item;resources;mesh;atlasTexture;constructor(t,e,i,r={}){super(t),this.item=e,this.resources=i,this.updateMesh(r),this.atlasTexture=this.createAtlasTexture(this.resources.getTextureAtlas())}setItem(t,e={}){this.item=t,this.updateMesh(e)}updateMesh(t={}){this.mesh=n.getItemMesh(this.item,this.resources,t),this.mesh.computeNormals(),this.mesh.rebuild(this.gl,{pos:!0,color:!0,texture:!0,normal:!0})}static getItemMesh(t,e,i){let r=t.getComponent("item_model",e)?.getAsString();if(r===void 0)return new dt;let s=e.getItemModel(T.parse(r));if(!s)throw new Error(`Item model ${r} does not exist (defined by item ${t.toString()})`);return s.getMesh(t,e,i)}getPerspective(){let t=R.create();return R.ortho(t,0,16,0,16,.1,500),t}drawItem(){let t=R.create();R.translate(t,t,[0,0,-32]),this.setShader(this.shaderProgram),this.setTexture(this.atlasTexture,this.resources.getPixelSize?.()),this.prepareDraw(t),this.drawMesh(this.mesh,{pos:!0,color:!0,texture:!0,normal:!0})}};var Jn=[0,0,0],Rr;(function(n){function t(c){let u=M.readObject(c)??{},d=M.readString(u.type)?.replace(/^minecraft:/,"");switch(d){case"constant":return new e(Z.fromJson(u.value)??Jn);case"dye":return new i(Z.fromJson(u.default)??Jn);case"grass":return new r(M.readNumber(u.temperature)??0,M.readNumber(u.downfall)??0);case"firework":return new s(Z.fromJson(u.default)??Jn);case"potion":return new a(Z.fromJson(u.default)??Jn);case"map_color":return new o(Z.fromJson(u.default)??Jn);case"custom_model_data":return new h(M.readInt(u.index)??0,Z.fromJson(u.default)??Jn);case"team":return new l(Z.fromJson(u.default)??Jn);default:throw new Error(`Invalid item tint type ${d}`)}}n.fromJson=t;class e{value;constructor(u){this.value=u}getTint(u){return this.value}}n.Constant=e;class i{default_color;constructor(u){this.default_color=u}getTint(u,d){let f=u.getComponent("dyed_color",d);return f?f.isCompound()?Z.intToRgb(f.getNumber("rgb")):Z.intToRgb(f.getAsNumber()):this.default_color}}n.Dye=i;class r{temperature;downfall;constructor(u,d){this.temperature=u,this.downfall=d}getTint(u){return[124/255,189/255,107/255]}}n.Grass=r;class s{default_color;constructor(u){this.default_color=u}getTint(u,d){let f=u.getComponent("firework_explosion",d);if(!f?.isCompound())return this.default_color;let p=f.get("colors");return!p||!p.isListOrArray()?this.default_color:(()=>{if(p.length===1)return Z.intToRgb(p.get(0).getAsNumber());let[g,_,y]=[0,0,0];for(let v of p.getItems())g+=(v.getAsNumber()&16711680)>>16,_+=(v.getAsNumber()&65280)>>8,y+=(v.getAsNumber()&255)>>0;return g/=p.length,_/=p.length,y/=p.length,[g/255,_/255,y/255]})()}}n.Firework=s;class a{default_color;constructor(u){this.default_color=u}getTint(u,d){let f=u.getComponent("potion_contents",d);if(!f)return this.default_color;let p=Ei.fromNbt(f);return Ei.getColor(p)}}n.Potion=a;class o{default_color;constructor(u){this.default_color=u}getTint(u,d){let f=u.getComponent("map_color",d);return f?Z.intToRgb(f.getAsNumber()):this.default_color}}n.MapColor=o;class h{index;default_color;constructor(u,d){this.index=u,this.default_color=d}getTint(u,d){let f=u.getComponent("custom_model_data",d);if(!f?.isCompound())return this.default_color;let p=f.getList("colors").get(this.index);return p?Z.fromNbt(p)??this.default_color:this.default_color}}n.CustomModelData=h;class l{default_color;constructor(u){this.default_color=u}getTint(u,d,f){return f.context_entity_team_color??this.default_color}}n.Team=l})(Rr=Rr||(Rr={}));var Cr;(function(n){function t(p){let m=M.readObject(p)??{},g=M.readString(m.type)?.replace(/^minecraft:/,"");switch(g){case"bed":return new e(T.parse(M.readString(m.texture)??""));case"banner":return new i(M.readString(m.color)??"");case"conduit":return new r;case"chest":return new s(T.parse(M.readString(m.texture)??""),M.readNumber(m.openness)??0);case"head":return new a(M.readString(m.kind)??"",typeof m.texture=="string"?T.parse(m.texture):void 0,M.readNumber(m.animation)??0);case"player_head":return new a("player",void 0,0);case"shulker_box":return new o(T.parse(M.readString(m.texture)??""),M.readNumber(m.openness)??0,M.readString(m.orientation)??"up");case"shield":return new h;case"trident":return new l;case"decorated_pot":return new c;case"standing_sign":return new u(M.readString(m.wood_type)??"",typeof m.texture=="string"?T.parse(m.texture):void 0);case"hanging_sign":return new d(M.readString(m.wood_type)??"",typeof m.texture=="string"?T.parse(m.texture):void 0);case"copper_golem_statue":{let _=M.readString(m.texture)??"",y=_.substring(_.lastIndexOf("/")+1),v=y.endsWith(".png")?y.slice(0,-4):y;return new f(T.parse(v))}default:return console.warn(`[deepslate]: Unknown special model ${g}`),{getMesh:()=>new dt}}}n.fromJson=t;class e{renderer;constructor(m){this.renderer=wt.bedRenderer(m)}getMesh(m,g){let _=this.renderer("head",g),y=this.renderer("foot",g),v=R.create();return R.translate(v,v,[0,0,-16]),_.merge(y.transform(v))}}class i{renderer;constructor(m){this.renderer=wt.bannerRenderer(m)}getMesh(m,g){let _=m.getComponent("banner_patterns",void 0),y=_?.isList()&&_.getType()===U.Compound?_:void 0,v=R.create();return R.translate(v,v,[8,24,8]),R.rotateY(v,v,Math.PI),R.scale(v,v,[2/3,2/3,2/3]),R.translate(v,v,[-8,-24,-8]),this.renderer(g,y).transform(v)}}class r{getMesh(m,g){return wt.conduitRenderer(g)}}class s{renderer;constructor(m,g){this.renderer=wt.chestRenderer(m)}getMesh(m,g){let _=R.create();return R.translate(_,_,[8,8,8]),R.rotateY(_,_,Math.PI),R.translate(_,_,[-8,-8,-8]),this.renderer(g).transform(_)}}class a{renderer;constructor(m,g,_){this.renderer=({skeleton:()=>wt.headRenderer(g??T.create("skeleton/skeleton"),2),wither_skeleton:()=>wt.headRenderer(g??T.create("skeleton/wither_skeleton"),2),zombie:()=>wt.headRenderer(g??T.create("zombie/zombie"),1),creeper:()=>wt.headRenderer(g??T.create("creeper/creeper"),2),dragon:()=>wt.dragonHeadRenderer(g),piglin:()=>wt.piglinHeadRenderer(g),player:()=>wt.headRenderer(g??T.create("player/wide/steve"),1)}[m]??(()=>()=>new dt))()}getMesh(m,g){return this.renderer(g)}}class o{renderer;constructor(m,g,_){this.renderer=wt.shulkerBoxRenderer(m)}getMesh(m,g){return this.renderer(g)}}class h{getMesh(m,g){let _=[],y=m.getComponent("banner_patterns",void 0),v=y?.isList()&&y.getType()===U.Compound?y:void 0,x=m.getComponent("base_color",void 0)?.getAsString();!x&&(v?.length??0)>0&&(x="white"),x&&(_.push({color:x,pattern:"base"}),v?.forEach(A=>{_.push({pattern:T.parse(A.getString("pattern")).path,color:A.getString("color")})}));let w=wt.shieldRenderer(g,_),b=R.create();return R.translate(b,b,[-3,1,0]),R.rotateX(b,b,-10*Math.PI/180),R.rotateY(b,b,-10*Math.PI/180),R.rotateZ(b,b,-5*Math.PI/180),w.transform(b)}}class l{getMesh(m,g){return new dt}}class c{getMesh(m,g){return wt.decoratedPotRenderer(g)}}class u{renderer;constructor(m,g){this.renderer=wt.signRenderer(g??T.create(m))}getMesh(m,g){return this.renderer(g)}}class d{renderer;constructor(m,g){this.renderer=wt.hangingSignRenderer(g??T.create(m))}getMesh(m,g){return this.renderer(!1,g)}}class f{renderer;constructor(m){this.renderer=wt.copperGolemStatueRenderer(m)}getMesh(m,g){let _=m.getComponent("block_state",void 0),y="standing";_ instanceof Et&&(y=_.getString("copper_golem_pose")||y);let v=R.create();return R.translate(v,v,[8,12,8]),R.rotateY(v,v,Math.PI),R.rotateZ(v,v,Math.PI),R.translate(v,v,[-8,-12,-8]),this.renderer(g,y).transform(v)}}})(Cr=Cr||(Cr={}));var mf=new dt,El;(function(n){function t(c){let u=M.readObject(c)??{},d=M.readString(u.type)?.replace(/^minecraft:/,"");switch(d){case"empty":return new e;case"model":return new i(T.parse(M.readString(u.model)??""),M.readArray(u.tints,Rr.fromJson)??[]);case"composite":return new r(M.readArray(u.models,n.fromJson)??[]);case"condition":return new s(s.propertyFromJson(u),n.fromJson(u.on_true),n.fromJson(u.on_false));case"select":return new a(a.propertyFromJson(u),new Map(M.readArray(u.cases,f=>M.readObject(f)??{})?.flatMap(f=>{let p=n.fromJson(f.model);return Array.isArray(f.when)?f.when.map(m=>[M.readString(m)??"",p]):[[M.readString(f.when)??"",p]]})),u.fallback?n.fromJson(u.fallback):void 0);case"range_dispatch":return new o(o.propertyFromJson(u),M.readNumber(u.scale)??1,M.readArray(u.entries,f=>{let p=M.readObject(f)??{};return{threshold:M.readNumber(p.threshold)??0,model:n.fromJson(p.model)}})??[],u.fallback?n.fromJson(u.fallback):void 0);case"special":return new h(Cr.fromJson(u.model),T.parse(M.readString(u.base)??""));case"bundle/selected_item":return new l;default:return console.warn(`[deepslate]: Unknown item model type '${d}'`),{getMesh:()=>new dt}}}n.fromJson=t;class e{getMesh(u,d,f){return new dt}}n.Empty=e;class i{modelId;tints;constructor(u,d){this.modelId=u,this.tints=d}getMesh(u,d,f){let p=d.getBlockModel(this.modelId);if(!p)return console.warn(`[deepslate]: Model '${this.modelId}' does not exist`),new dt;let m=_=>_<this.tints.length?this.tints[_].getTint(u,d,f):[1,1,1],g=p.getMesh(d,ht.none(),m);return g.transform(p.getDisplayTransform(f.display_context??"gui")),g}}n.Model=i;class r{models;constructor(u){this.models=u}getMesh(u,d,f){let p=new dt;return this.models.forEach(m=>p.merge(m.getMesh(u,d,f))),p}}n.Composite=r;class s{property;onTrue;onFalse;constructor(u,d,f){this.property=u,this.onTrue=d,this.onFalse=f}getMesh(u,d,f){return(this.property(u,d,f)?this.onTrue:this.onFalse).getMesh(u,d,f)}static propertyFromJson(u){let d=M.readString(u.property)?.replace(/^minecraft:/,"");switch(d){case"fishing_rod/cast":case"selected":case"carried":case"extended_view":return(_,y,v)=>v[d]??!1;case"view_entity":return(_,y,v)=>v.context_entity_is_view_entity??!1;case"using_item":return(_,y,v)=>(v.use_duration??-1)>=0;case"bundle/has_selected_item":return(_,y,v)=>(v["bundle/selected_item"]??-1)>=0;case"broken":return(_,y,v)=>{let x=_.getComponent("damage",y)?.getAsNumber(),w=_.getComponent("max_damage",y)?.getAsNumber();return x!==void 0&&w!==void 0&&x>=w-1};case"damaged":return(_,y,v)=>{let x=_.getComponent("damage",y)?.getAsNumber(),w=_.getComponent("max_damage",y)?.getAsNumber();return x!==void 0&&w!==void 0&&x>=1};case"has_component":let f=T.parse(M.readString(u.component)??""),p=M.readBoolean(u.ignore_default)??!1;return(_,y,v)=>_.hasComponent(f,p?void 0:y);case"keybind_down":let m=M.readString(u.keybind)??"";return(_,y,v)=>v.keybind_down?.includes(m)??!1;case"custom_model_data":let g=M.readInt(u.index)??0;return(_,y,v)=>{let x=_.getComponent("custom_model_data",y);if(!x?.isCompound())return!1;let w=x.getList("flags").getNumber(g);return w!==void 0&&w!==0};default:return console.warn(`[deepslate]: Unknown condition property '${d}'`),()=>!1}}}n.Condition=s;class a{property;cases;fallback;constructor(u,d,f){this.property=u,this.cases=d,this.fallback=f}getMesh(u,d,f){let p=this.property(u,d,f);return((p!==null?this.cases.get(p):void 0)??this.fallback)?.getMesh(u,d,f)??mf}static propertyFromJson(u){let d=M.readString(u.property)?.replace(/^minecraft:/,"");switch(d){case"main_hand":return(g,_,y)=>y.main_hand??"right";case"display_context":return(g,_,y)=>y.display_context??"gui";case"context_dimension":return(g,_,y)=>y.context_dimension?.toString()??null;case"charge_type":let f=T.create("firework_rocket");return(g,_,y)=>{let v=g.getComponent("charged_projectiles",_);return!v?.isList()||v.length===0?"none":v.filter(x=>x.isCompound()?T.parse(x.getString("id")).equals(f):!1).length>0?"rocket":"arrow"};case"trim_material":return(g,_,y)=>{let v=g.getComponent("trim",_);return v?.isCompound()?T.parse(v.getString("material")).toString():null};case"block_state":let p=M.readString(u.block_state_property)??"";return(g,_,y)=>{let v=g.getComponent("block_state",_);return v?.isCompound()?v.getString(p):null};case"local_time":return(g,_,y)=>"NOT IMPLEMENTED";case"context_entity_type":return(g,_,y)=>y.context_entity_type?.toString()??null;case"custom_model_data":let m=M.readInt(u.index)??0;return(g,_,y)=>{let v=g.getComponent("custom_model_data",_);if(!v?.isCompound())return null;let x=v.getList("strings");return x.length<=m?null:x.getString(m)};default:return console.warn(`[deepslate]: Unknown select property '${d}'`),()=>null}}}n.Select=a;class o{property;scale;fallback;entries;constructor(u,d,f,p){this.property=u,this.scale=d,this.fallback=p,this.entries=f.sort((m,g)=>m.threshold-g.threshold)}getMesh(u,d,f){let p=this.property(u,d,f)*this.scale,m=this.fallback;for(let g of this.entries)if(g.threshold<=p)m=g.model;else break;return m?.getMesh(u,d,f)??mf}static propertyFromJson(u){let d=M.readString(u.property)?.replace(/^minecraft:/,"");switch(d){case"bundle/fullness":let f=function(y,v){let x=y.getComponent("bundle_contents",v);return x?.isListOrArray()?x.map(b=>b.isCompound()?yr.fromNbt(b):void 0).reduce((b,A)=>{if(A===void 0)return b;if(A.hasComponent("bundle_contents",v))return b+f(A,v)+1/16;let I=A.getComponent("bees",v);if(I?.isListOrArray()&&I.length>0)return b+1;let C=A.getComponent("max_stack_size",v)?.getAsNumber()??1;return b+A.count/C},0):0};return(y,v,x)=>f(y,v);case"damage":{let y=M.readBoolean(u.normalize)??!0;return(v,x,w)=>{let b=v.getComponent("max_damage",x)?.getAsNumber()??0,A=Ot(v.getComponent("damage",x)?.getAsNumber()??0,0,b);return y?Ot(A/b,0,1):Ot(A,0,b)}}case"count":{let y=M.readBoolean(u.normalize)??!0;return(v,x,w)=>{let b=v.getComponent("max_stack_size",x)?.getAsNumber()??1;return y?Ot(v.count/b,0,1):Ot(v.count,0,b)}}case"cooldown":return(y,v,x)=>{let w=y.getComponent("use_cooldown",v),b=w?.isCompound()?T.parse(w.getString("cooldown_group")??y.id):y.id;return x.cooldown_percentage?.[b.toString()]??0};case"time":switch(M.readString(u.source)??"daytime"){case"moon_phase":return(y,v,x)=>(x.game_time??0)/24e3%8/8;case"random":return(y,v,x)=>Math.random();default:return(y,v,x)=>{let b=(x.game_time??0)/24e3%1-.25,A=.5-Math.cos(b*Math.PI)/2;return(b*2+A)/3}}case"compass":return(y,v,x)=>x.compass_angle??0;case"crossbow/pull":return(y,v,x)=>x["crossbow/pull"]??0;case"use_duration":let m=M.readBoolean(u.remaining)??!0;return(y,v,x)=>x.use_duration===void 0||x.use_duration<0?0:m?Math.max((x.max_use_duration??0)-x.use_duration,0):x.use_duration;case"use_cycle":let g=M.readNumber(u.period)??1;return(y,v,x)=>x.use_duration===void 0||x.use_duration<0?0:Math.max((x.max_use_duration??0)-(x.use_duration??0),0)%g;case"custom_model_data":let _=M.readInt(u.index)??0;return(y,v,x)=>{let w=y.getComponent("custom_model_data",v);return w?.isCompound()?w.getList("floats").getNumber(_):0};default:return console.warn(`[deepslate]: Unknown range dispatch property '${d}'`),()=>0}}}n.RangeDispatch=o;class h{specialModel;base;constructor(u,d){this.specialModel=u,this.base=d}getMesh(u,d,f){let p=this.specialModel.getMesh(u,d),m=d.getBlockModel(this.base);return m?(p.transform(m.getDisplayTransform(f.display_context??"gui")),p):(console.warn(`[deepslate]: Special model base '${this.base}' does not exist`),new dt)}}n.Special=h;class l{getMesh(u,d,f){let p=f["bundle/selected_item"];if(p===void 0||p<0)return new dt;let m=u.getComponent("bundle_contents",d);if(!m?.isListOrArray())return new dt;let g=m.get(p);if(g===void 0||!g.isCompound())return new dt;let _=yr.fromNbt(g);return Qs.getItemMesh(_,d,{...f,"bundle/selected_item":-1,selected:!1,carried:!1,use_duration:-1})}}n.BundleSelectedItem=l})(El=El||(El={}));var s1=/^minecraft:(\w+)_wall_(head|skull)$/,a1={south:"0",east:"4",north:"8",west:"12"},o1={south:[0,-1],east:[-1,0],north:[0,1],west:[1,0]},Al=1/4;function Tl(n,t,e,i){let r=(u,d,f=e)=>wt.getBlockMesh(new Tt(u,d),void 0,f,i);if(n==="minecraft:shulker_box")return r("minecraft:purple_shulker_box",t,l1(e));let[,s,a]=n.match(s1)??[];if(!s)return r(n,t);let o=t.facing??"north",h=r(`minecraft:${s}_${a}`,{rotation:a1[o]}),[l,c]=o1[o];for(let u of h.quads.flatMap(d=>d.vertices()))u.pos=u.pos.add({x:Al*l,y:Al,z:Al*c});return h}function l1(n){return{getTextureUV:t=>n.getTextureUV(t.path==="entity/shulker/shulker_purple"?T.create("entity/shulker/shulker"):t)}}var c1=[145/255,189/255,89/255],h1=[119/255,171/255,47/255],u1=[63/255,118/255,228/255],f1=["down","up","north","south","west","east"],d1=1/64,p1=1/1e3,js={x:.6,down:.5,up:1,z:.8};for(let[n,t]of[[Ie.grass({}),c1],[Ie.oak_leaves({}),h1],[Ie.water({}),u1]]){let e=Object.keys(Ie).filter(i=>Ie[i]({}).join()===n.join());for(let i of e)Ie[i]=()=>t}var ta=class{constructor({states:t,models:e,atlas:i}){this.states=t,this.atlas=i;let r=Object.fromEntries(Object.keys(i.places).map(s=>[s,s]));this.models=new Map(Object.entries(e).map(([s,a])=>[s,mt.fromJson({elements:a.elements,textures:r})])),this.translucent=i.translucent.map(s=>i.places[s]),this.known=new Map}getTextureUV(t){let{side:e,places:i}=this.atlas;return(i[t.toString()]??i["minecraft:missing"]).map(r=>r/e)}getBlockModel(t){return this.models.get(t.toString())??null}of(t,e,i){let r=this.states[t],s=r.isWet?i:e,a=(t*64+e)*64+s;return this.known.has(a)||this.known.set(a,[...this.made(r,gf(s)),...r.isWet?this.water(gf(e)):[]]),this.known.get(a)}made({name:t,properties:e,parts:i,isSpecial:r},s){let a=new Ks(void 0,i.map(h=>({apply:h}))),o=new dt;return o.merge(a.getMesh(T.parse(t),e,this,this,s)),r&&o.merge(Tl(t,{...e,waterlogged:"false"},this,s)),o.quads.map(h=>this.plain(h))}water(t){return Tl("minecraft:water",{level:"0"},this,t).quads.map(i=>{let r=this.plain(i);return{...r,positions:r.positions.map((s,a)=>s-p1*r.axis[a%3])}})}plain(t){let e=t.vertices(),i=t.normal().components(),r=e.map(l=>l.texture[0]),s=e.map(l=>l.texture[1]),[a,o]=[_f(r),_f(s)],h=d1/this.atlas.side;return{positions:e.flatMap(l=>l.pos.components()),places:e.flatMap((l,c)=>[r[c]+Math.sign(a-r[c])*h,s[c]+Math.sign(o-s[c])*h]),color:e[0].color.map(l=>l*m1(i)),axis:g1(i),isClear:this.isClear(a*this.atlas.side,o*this.atlas.side)}}isClear(t,e){return this.translucent.some(([i,r,s,a])=>i<t&&t<s&&r<e&&e<a)}};function gf(n){return Object.fromEntries(f1.map((t,e)=>[t,!!(n&1<<e)]))}function _f(n){return(Math.min(...n)+Math.max(...n))/2}function m1([n,t,e]){return n*n*js.x+e*e*js.z+t*t*(t<0?js.down:js.up)}function g1(n){let t=n.findIndex(e=>Math.abs(e)>.999);return t<0?null:[0,1,2].map(e=>e===t?Math.sign(n[e]):0)}async function _1(){let n=await Zc(Ue("build").textContent),t=Ue("canvas"),e=new _s(t,n,await Jc(n.atlas),new ta(n));document.title=n.name,x1(t,n,e),window.shoot=(i,r,s)=>(t.width=r.width*s,t.height=r.height*s,e.draw(i,r),t.toDataURL("image/png").split(",")[1]),Ue("message").hidden=!0,document.body.dataset.ready="yes"}function x1(n,t,e){let{box:i}=t,r={center:i.center.map((f,p)=>f+t.corner[p]),scale:i.scale},s=f=>new Mt(...f.map((p,m)=>(p-i.center[m])*i.scale)),a=new ds,o=t.numbers[0],h=!1,l=()=>{h=!1;let f=Math.min(window.devicePixelRatio||1,2);n.width=Math.max(1,Math.round(n.clientWidth*f)),n.height=Math.max(1,Math.round(n.clientHeight*f)),a.aspect=n.width/n.height,a.apply(),e.draw(o,a.json(r,n.width,n.height))},c=()=>{h||requestAnimationFrame(l),h=!0};a.aspect=n.clientWidth/Math.max(n.clientHeight,1),a.frame(qc(s(i.low),s(i.high))),Yc(n,a,c),window.addEventListener("resize",c);let u={bar:Ue("timeline"),play:Ue("play"),slider:Ue("frame"),label:Ue("frame-label"),rate:Ue("rate")};new ps(u,f=>{o=t.numbers[f],c()},c).take(t.numbers.length),c()}_1().catch(n=>{Ue("message").textContent=`The build cannot be shown: ${n.message}`,document.body.dataset.ready="no"});})();
